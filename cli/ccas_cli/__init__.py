"""The command line `ccas`: `main` puts the commands together, one file holds one command."""
