"""Thousands of encounters: drawn from a seed, sailed in processes, counted, and told in a report."""
