"""The live fleet kept in memory between transactions, for a store that one process alone writes."""
