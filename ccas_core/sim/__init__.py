"""The world moves: scenarios, voyages, what is written of them, and what they are worth."""
