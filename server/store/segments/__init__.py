"""The bytes of run segments, by the hash of their content: in a folder, or in an object store."""
