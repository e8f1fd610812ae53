"""What the paper's text says, equation by equation, held against the code."""
