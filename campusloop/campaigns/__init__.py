"""Many independent jobs on many processes: of this machine, or of a Dask cluster.

The results do not depend on where the jobs run: each job carries its seed. Results come in the jobs' order.
"""
