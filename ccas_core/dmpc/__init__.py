"""Layer 2: each ship's MPC problem and the negotiation by NADMM.  It never sees a rule.

The only package that imports casadi.
"""
