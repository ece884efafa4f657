0 BEGIN PGM SMALL_STATIC MM
1 ; TRUNNION small-static
2 ; Measuring cycle small-static, machine table-bc. About 2 minutes without stops.
3 ; Setup low: R-test, nest at X150 Y0 Z60 of the table, ball in the spindle.
4 ; Check before the start:
5 ; 1. Tool length and all tool offsets are zero: the programmed point is the centre of ball or nest in
6 ; the spindle, on the spindle line.
7 ; 2. Work offset G54 [preset]: with all axes at 0 that point is in the origin of the machine file [the
8 ; line of C goes through X0 Y0 Z0 of it].
9 ; 3. Senses: B+ turns the table right-handed about +Y, C+ turns the table right-handed about +Z, X+
10 ; moves the tool to +X, Y+ moves the tool to +Y, Z+ moves the tool to +Z.
11 ; 4. Five-axis transformation and tool-point following [TCP, RTCP, TRAORI, M128] are off, linear axes
12 ; follow by the program.
13 ; 5. Spindle retracted and locked, way free up to 100 mm above the highest ball, feed override 100
14 ; percent while it measures.
15 CYCL DEF 32.0 TOLERANCE
16 CYCL DEF 32.1 T1.0
17 M127
18 M129
19 L Z+160.0000 R0 F2000.0
20 L B+0.0000 C+2.5000 R0 F1800.0
21 L X+149.8572 Y+6.5429 R0 F2000.0
22 ; Mount low: R-test, nest at X150 Y0 Z60 of the table, ball in the spindle. Then cycle start.
23 STOP
24 L Z+60.0000 R0 F300.0
25 ; Setup low: all probes in range? Start the recording. Then cycle start.
26 STOP
27 L X+143.8799 Y-9.8105 Z+72.8171 B-5.0000 C-3.7500 R0 F2819.515
28 L X+135.0581 Y-26.0472 Z+84.7400 B-10.0000 C-10.0000 R0 F2882.655
29 L X+143.6312 Y-13.0734 Z+72.7953 B-5.0000 C-5.0000 R0 F3213.317
30 L X+150.0000 Y+0.0000 Z+60.0000 B+0.0000 C+0.0000 R0 F3154.54
31 CYCL DEF 9.0 DWELL TIME
32 CYCL DEF 9.1 DWELL 2.5
33 L X+149.4292 Y+13.0734 C+5.0000 R0 F2143.063
34 CYCL DEF 9.0 DWELL TIME
35 CYCL DEF 9.1 DWELL 2.5
36 L X+152.3318 Y-6.5429 Z+53.4062 B+2.5000 C-2.5000 R0 F2277.987
37 L X+152.3884 Y-26.0472 Z+46.8969 B+5.0000 C-10.0000 R0 F2258.92
38 L X+154.6585 Y+0.0000 Z+46.6983 C+0.0000 R0 F2149.463
39 CYCL DEF 9.0 DWELL TIME
40 CYCL DEF 9.1 DWELL 2.5
41 L X+154.0899 Y+13.0734 Z+46.7481 C+5.0000 R0 F2143.063
42 CYCL DEF 9.0 DWELL TIME
43 CYCL DEF 9.1 DWELL 2.5
44 L X+155.8958 Y+26.0472 Z+33.4370 B+10.0000 C+10.0000 R0 F3000.377
45 L X+155.4810 Y+38.8229 Z+20.4555 B+15.0000 C+15.0000 R0 F3010.831
46 L X+155.8958 Y+26.0472 Z+33.4370 B+10.0000 C+10.0000 R0 F3010.831
47 L X+154.0899 Y+13.0734 Z+46.7481 B+5.0000 C+5.0000 R0 F3000.377
48 CYCL DEF 9.0 DWELL TIME
49 CYCL DEF 9.1 DWELL 2.5
50 L X+154.6585 Y+0.0000 Z+46.6983 C+0.0000 R0 F2143.063
51 CYCL DEF 9.0 DWELL TIME
52 CYCL DEF 9.1 DWELL 2.5
53 L X+151.1923 Y+19.5789 Z+53.4560 B+2.5000 C+7.5000 R0 F2292.172
54 L X+144.8889 Y+38.8229 Z+60.0000 B+0.0000 C+15.0000 R0 F2359.408
55 L X+149.4292 Y+13.0734 C+5.0000 R0 F2174.316
56 CYCL DEF 9.0 DWELL TIME
57 CYCL DEF 9.1 DWELL 2.5
58 L X+150.0000 Y+0.0000 C+0.0000 R0 F2143.063
59 CYCL DEF 9.0 DWELL TIME
60 CYCL DEF 9.1 DWELL 2.5
61 L X+149.8572 Y+6.5429 C+2.5000 R0 F2141.468
62 L Z+160.0000 R0 F300.0
63 CYCL DEF 32.0 TOLERANCE
64 CYCL DEF 32.1
65 M30
66 END PGM SMALL_STATIC MM
