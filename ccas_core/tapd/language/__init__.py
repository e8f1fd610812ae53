"""The language of conditions: text, formula, and the three meanings of a formula.

`syntax` reads a text; `compiler` gives it types and turns it into a `formula`; `code` runs a formula on
floats, exactly where floats do not decide, `threefold` runs it where facts are unknown, and the symbolic
meaning, for proofs, is built from the same formula.
"""
