"""How one thread writes a campus's database: the lock, the transaction of a group, failures and pauses."""
