"""How panels move: the principle of three units, in vector form."""
