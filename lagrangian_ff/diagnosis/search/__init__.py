"""Which effect would explain what is left: candidates, their gain in evidence, and chance."""
