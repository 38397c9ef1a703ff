"""The live fleet kept in memory between transactions, by the writer of a store."""
