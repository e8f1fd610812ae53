"""Plugins shipped with CCAS: what a YAML ruleset cannot say.

They use the hooks of `ccas_core.hookspecs` and import from `ccas_core` only, as anybody's would.
`plugins/example_harbour` in the repository is a complete plugin of somebody else.
"""
