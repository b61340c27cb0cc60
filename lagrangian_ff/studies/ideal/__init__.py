"""Fig. 2: learning the inverse dynamics of ideal rigid-body robots."""
