"""`bounds`: rigorous upper and lower bounds of a limit load or of a factor of safety, on the scene that a deck draws.

scene       what of a deck limit analysis knows, from its cards; anything else is an error that names the card
strength    cohesion and friction at a factor of safety, Davis' reduction, strength profiles
lines       the drawn lines cut at each other
triangles   triangles between the lines; halving of those that are marked
model       the scene on triangles: weights, pore pressures, loads and supports of both ends of a phase
cone        stresses inside the cones of yield, by Clarabel
upper       6-node triangles, linear strain
lower       linear stresses, jumps across edges
search      a limit load, or a factor of safety, and triangles halved where most is dissipated
picture     the mechanism
verb        words of the command line
"""
