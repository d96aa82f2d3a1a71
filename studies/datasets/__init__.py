"""Public data sets as recordings: OptiOdom, Husky and Labyrinth."""
