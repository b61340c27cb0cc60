"""Fig. 3: learning inverse dynamics under friction and noise."""
