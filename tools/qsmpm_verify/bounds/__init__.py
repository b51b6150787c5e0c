"""`bounds`: rigorous upper and lower bounds of a limit load or a factor of safety, for the scene that a deck defines.

scene       bodies, strengths, and loads at both ends of a phase
words       names, numbers and boxes of keywords; anything unsupported is an error that names the keyword
reader      keywords of the model
phases      keywords of the phases, and the scene of the requested phase
flow        groundwater flow, as computed by the program
heads       its heads on triangles, and the phreatic surface
deformed    outlines moved with the material points of a run
strength    cohesion and friction at a factor of safety, Davis' reduction, strength profiles
lines       the lines of the geometry, intersected
triangles   triangular mesh between the lines; bisection of marked triangles
model       the scene on triangles: weights, pore pressures, loads and supports of both ends of a phase
contact     rigid bodies: tractions on them, and dissipation of velocity jumps
nodes       nodes of the upper bound, doubled at the foot of a wall
cone        stresses inside the yield cones, by Clarabel
upper       6-node triangles, linear strain
lower       linear stresses, jumps across edges
search      a limit load, or a factor of safety, and bisection of triangles where the dissipation is largest
picture     the mechanism
verb        arguments of the command line
"""
