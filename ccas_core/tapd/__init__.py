"""Layer 1: who gives way to whom, and why (TAPD).  It never sees a controller."""
