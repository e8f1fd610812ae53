"""A ship as an agent: its knowledge, its messages, its decision; no coordinator, no shared memory."""
