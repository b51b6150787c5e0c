// A hill on level ground: gmsh -2 -order 2 5_hill.geo -o 5_hill.msh
// The whole rectangle is meshed: the soil, and the air it may move into.
SetFactory("Built-in");
Mesh.MshFileVersion = 4.1;
Point(1) = {0, 0, 0, 0.8};   Point(2) = {12, 0, 0, 0.8};
Point(3) = {12, 2, 0, 0.6};  Point(4) = {7, 2, 0, 0.3};
Point(5) = {4, 5, 0, 0.25};  Point(6) = {0, 5, 0, 0.6};
Point(7) = {12, 5, 0, 1.0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 1};
Line(7) = {3, 7}; Line(8) = {7, 5};
Curve Loop(1) = {1, 2, 3, 4, 5, 6};
Curve Loop(2) = {7, 8, -4, -3};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Physical Surface("soil") = {1};
Physical Surface("air") = {2};
Physical Curve("base") = {1};
Physical Curve("left") = {6};
Physical Curve("right") = {2, 7};
