"""How sure a model is: of its torques, of its effects' parameters, of what it learned from."""
