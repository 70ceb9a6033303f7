two modes by hand
1 1 1 1 1 1 %enabled
3 %states
0 0 2 0 1 0 %by motion
-1.2 -4 0
1 0 0
0 0 -1.5
0 0 1 0 0 0
0 0 0 0 0 0
0 0 0 0 0.5 0
0 0 0
0 0 0
0.8 0 0
0 0 0
0 0 0.3
0 0 0
