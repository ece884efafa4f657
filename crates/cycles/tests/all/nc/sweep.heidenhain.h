0 BEGIN PGM SMALL_SWEEP MM
1 ; TRUNNION small-sweep
2 ; Measuring cycle small-sweep, machine table-bc. About 2 minutes without stops.
3 ; Setup low: ball bar of 100 mm, its ball at X0 Y0 Z60 of the table, the other in the spindle.
4 ; On the fly: straight blocks at most 500 um off the path of the tool point, shortest block 12500.0
5 ; ms. Recording begins and ends with 3 strokes of 0.2 mm there and back [synchronisation move].
6 ; Check before the start:
7 ; 1. Tool length and all tool offsets are zero: the programmed point is the centre of ball or nest in
8 ; the spindle, on the spindle line.
9 ; 2. Work offset G54 [preset]: with all axes at 0 that point is in the origin of the machine file [the
10 ; line of C goes through X0 Y0 Z0 of it].
11 ; 3. Senses: B+ turns the table right-handed about +Y, C+ turns the table right-handed about +Z, X+
12 ; moves the tool to +X, Y+ moves the tool to +Y, Z+ moves the tool to +Z.
13 ; 4. Five-axis transformation and tool-point following [TCP, RTCP, TRAORI, M128] are off, linear axes
14 ; follow by the program.
15 ; 5. Spindle retracted and locked, way free up to 100 mm above the highest ball, feed override 100
16 ; percent while it measures.
17 CYCL DEF 32.0 TOLERANCE
18 CYCL DEF 32.1 T0.5
19 M127
20 M129
21 L Z+160.0000 R0 F2000.0
22 L B+0.0000 C+0.0000 R0 F1800.0
23 L X+0.0000 Y+100.0000 R0 F2000.0
24 ; Mount low: ball bar of 100 mm, its ball at X0 Y0 Z60 of the table, the other in the spindle. Then
25 ; cycle start.
26 STOP
27 L Z+60.0000 R0 F300.0
28 ; Setup low: put the bar between the balls. Start the recording. Then cycle start.
29 STOP
30 ; dwell before the synchronisation move
31 CYCL DEF 9.0 DWELL TIME
32 CYCL DEF 9.1 DWELL 1.0
33 ; synchronisation move of axis Y
34 L Y+100.2000 R0 F60.0
35 L Y+100.0000 R0 F60.0
36 L Y+100.2000 R0 F60.0
37 L Y+100.0000 R0 F60.0
38 L Y+100.2000 R0 F60.0
39 L Y+100.0000 R0 F60.0
40 ; dwell after the synchronisation move
41 CYCL DEF 9.0 DWELL TIME
42 CYCL DEF 9.1 DWELL 1.0
43 L C-7.5000 R0 F1800.0
44 ; dwell before a pass
45 CYCL DEF 9.0 DWELL TIME
46 CYCL DEF 9.1 DWELL 1.0
47 ; pass of C at +1800 deg/min, 12.5 s with run-in and run-out
48 L C+367.5000 R0 F1800.0
49 ; dwell before a pass
50 CYCL DEF 9.0 DWELL TIME
51 CYCL DEF 9.1 DWELL 1.0
52 ; pass of C at -1800 deg/min, 12.5 s with run-in and run-out
53 L C-7.5000 R0 F1800.0
54 L C+0.0000 R0 F1800.0
55 ; dwell before the synchronisation move
56 CYCL DEF 9.0 DWELL TIME
57 CYCL DEF 9.1 DWELL 1.0
58 ; synchronisation move of axis Y
59 L Y+100.2000 R0 F60.0
60 L Y+100.0000 R0 F60.0
61 L Y+100.2000 R0 F60.0
62 L Y+100.0000 R0 F60.0
63 L Y+100.2000 R0 F60.0
64 L Y+100.0000 R0 F60.0
65 ; dwell after the synchronisation move
66 CYCL DEF 9.0 DWELL TIME
67 CYCL DEF 9.1 DWELL 1.0
68 ; Setup low: take the bar out. Then cycle start.
69 STOP
70 L Z+160.0000 R0 F300.0
71 CYCL DEF 32.0 TOLERANCE
72 CYCL DEF 32.1
73 M30
74 END PGM SMALL_SWEEP MM
