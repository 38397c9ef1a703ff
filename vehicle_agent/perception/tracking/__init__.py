"""Objects of single scans become tracks with identities of their own."""
