// A bank of 4 m at 45 degrees, two layers: gmsh -2 -order 2 hill.geo -o hill.msh
// The whole rectangle is meshed: the soil, and the air it may move into.
SetFactory("Built-in");
Mesh.MshFileVersion = 4.1;
Point(1) = {0, 0, 0, 1.5};   Point(2) = {18, 0, 0, 1.5};
Point(3) = {18, 3, 0, 1.2};  Point(4) = {12, 3, 0, 0.5};
Point(5) = {8, 7, 0, 0.5};   Point(6) = {0, 7, 0, 1.2};
Point(7) = {18, 7, 0, 1.5};  Point(8) = {0, 3, 0, 1.2};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 5}; Line(5) = {5, 6}; Line(6) = {6, 8}; Line(7) = {8, 1};
Line(8) = {4, 8}; Line(9) = {3, 7}; Line(10) = {7, 5};
Curve Loop(1) = {1, 2, 3, 8, 7};
Curve Loop(2) = {-8, 4, 5, 6};
Curve Loop(3) = {9, 10, -4, -3};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Plane Surface(3) = {3};
Physical Surface("rock") = {1};
Physical Surface("bank") = {2};
Physical Surface("air") = {3};
Physical Curve("base") = {1};
Physical Curve("left") = {6, 7};
Physical Curve("right") = {2, 9};
