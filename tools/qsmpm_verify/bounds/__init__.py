"""`bounds`: rigorous upper and lower bounds of a limit load or of a factor of safety, on the scene that a deck draws.

scene       bodies, strengths, and what acts on them at both ends of a phase
words       names, numbers and boxes of cards; anything that is not known is an error that names the card
reader      cards of the model
phases      cards of the phases, and the scene of the one that is asked for
flow        water that flows, as the program finds it
heads       its heads on triangles, and its surface
deformed    outlines moved with the material points of a run
strength    cohesion and friction at a factor of safety, Davis' reduction, strength profiles
lines       the drawn lines cut at each other
triangles   triangles between the lines; halving of those that are marked
model       the scene on triangles: weights, pore pressures, loads and supports of both ends of a phase
contact     rigid bodies: tractions on them, and what jumps of velocity dissipate
nodes       nodes of the upper bound, torn at the foot of a wall
cone        stresses inside the cones of yield, by Clarabel
upper       6-node triangles, linear strain
lower       linear stresses, jumps across edges
search      a limit load, or a factor of safety, and triangles halved where most is dissipated
picture     the mechanism
verb        words of the command line
"""
