"""Proofs about rulesets: for every position, course, speed and fact, or the ships that show the opposite.

The formulas are those that run at sea (`tapd.language`); here they get their third meaning, terms of a
solver. The only place for z3.
"""
