"""What studies on trajectories of rising speed share: the motions, and how models are learned."""
