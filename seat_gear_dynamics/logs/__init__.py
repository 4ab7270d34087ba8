"""Bags on disk: the contract's topics and schemas, a writer of bounded loss, a reader that survives harm."""
