"""The compiled kernels: the groups that each command needs, the validity of their caches, and compilation."""
