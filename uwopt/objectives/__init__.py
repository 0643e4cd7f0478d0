"""How good a design is: objectives, and requirements as margins."""
