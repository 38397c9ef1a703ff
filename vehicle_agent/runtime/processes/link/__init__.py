"""The link as a process, and its mail to and from the other processes."""
