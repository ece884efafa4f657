//! What the catalogue says of each effect: what it is, its likely cause, what shows it; and what a sign of a parameter means.

#[rustfmt::skip]
pub(super) const ENTRIES: &[[&str; 3]] = &[
    // angular-motion
    ["The carriage nods, swings or rolls while it travels.", "Der Schlitten nickt, giert oder rollt beim Verfahren.", "キャリッジが移動中にピッチ・ヨー・ロールする。"],
    ["Guideways not parallel or bent; weight of the carriage overhanging the bed.", "Führungen nicht parallel oder verbogen; Gewicht des Schlittens, der über das Bett hinausragt.", "案内面が平行でない、または曲がっている。ベッドから張り出したキャリッジの重量。"],
    ["Poses all along the axis with other axes at different places, so that the arm changes; two tool lengths.", "Stellungen über die ganze Achse mit den anderen Achsen an verschiedenen Orten, sodass sich der Hebelarm ändert; zwei Werkzeuglängen.", "他の軸の位置を変えて腕の長さを変えながら、軸全長の姿勢を測る。工具長を 2 通りにする。"],
    // artefact-form
    ["The balls of the plate are not exactly where its drawing says.", "Die Kugeln der Platte sind nicht genau dort, wo die Zeichnung sie nennt.", "プレートの球が図面どおりの位置にない。"],
    ["The artefact was never calibrated, or it has changed since; not an error of the machine.", "Der Prüfkörper wurde nie kalibriert oder hat sich seitdem verändert; kein Fehler der Maschine.", "アーティファクトが未校正、または校正後に変化した。機械の誤差ではない。"],
    ["Measuring the artefact in several placements, turned against each other.", "Den Prüfkörper in mehreren, gegeneinander verdrehten Lagen messen.", "アーティファクトを互いに回転させた複数の置き方で測る。"],
    // axial-error-motion
    ["The table rises and falls while it turns.", "Der Tisch hebt und senkt sich beim Drehen.", "テーブルが回転しながら上下する。"],
    ["Axial run-out of the bearing: wavy rings, rollers of unequal size.", "Axialer Schlag des Lagers: wellige Ringe, ungleich große Wälzkörper.", "軸受の軸方向の振れ：軌道輪のうねり、転動体の寸法差。"],
    ["Turning the axis with the ball on its line (one radius separates it from a tilt only for n > 1).", "Die Achse mit der Kugel auf ihrer Linie drehen (ein Radius trennt es nur für n > 1 von einer Neigung).", "球を軸線上に置いて軸を回す（半径が一つでは n > 1 の場合のみ傾きと分離できる）。"],
    // backlash
    ["The axis stops short of its target by the same amount from either side.", "Die Achse hält von beiden Seiten um denselben Betrag vor dem Ziel.", "軸がどちらの側からも目標の手前で同じ量だけ止まる。"],
    ["Errors in the positioning mechanism: play in worm, gear, screw nut or coupling; wrong backlash compensation.", "Fehler im Stellmechanismus: Spiel in Schnecke, Getriebe, Spindelmutter oder Kupplung; falsche Umkehrspielkompensation.", "送り機構の誤差：ウォーム、歯車、ねじナット、カップリングの遊び。バックラッシ補正の誤り。"],
    ["Approaching every pose from both directions of this axis.", "Jede Stellung aus beiden Richtungen dieser Achse anfahren.", "すべての姿勢にこの軸の両方向から近づく。"],
    // ball-form
    ["The ball is not quite round, and the probes touch another spot of it at every pose.", "Die Kugel ist nicht ganz rund, und die Messtaster berühren in jeder Stellung eine andere Stelle.", "球が真球でなく、変位計の当たる場所が姿勢ごとに変わる。"],
    ["Ball of a low grade, worn, dirty or rusty; not an error of the machine.", "Kugel von geringer Güte, abgenutzt, verschmutzt oder rostig; kein Fehler der Maschine.", "球の等級が低い、または摩耗・汚れ・さびがある。機械の誤差ではない。"],
    ["Many poses of both rotary axes; the ball turned in its holder, or another ball, changes it and leaves the machine's errors.", "Viele Stellungen beider Drehachsen; die Kugel im Halter gedreht oder eine andere Kugel ändert es und lässt die Fehler der Maschine stehen.", "両回転軸の多数の姿勢。球をホルダ内で回すか別の球にするとこれだけが変わり、機械の誤差は変わらない。"],
    // ball-setting
    ["The ball does not sit exactly where the setup file says.", "Die Kugel sitzt nicht genau dort, wo die Aufstellungsdatei sie nennt.", "球が段取りファイルに書かれた位置に正確にはない。"],
    ["Clamping the ball or the nest by hand.", "Kugel oder Nest von Hand aufgespannt.", "球またはネストの手作業による取付け。"],
    ["Always.", "Immer.", "常に。"],
    // ballscrew-pitch
    ["The axis runs ahead and behind in a wave along its travel, the same at every turn of its screw.", "Die Achse läuft entlang ihres Weges wellenförmig vor und nach, bei jeder Umdrehung der Spindel gleich.", "軸が移動に沿って波状に進み遅れし、ねじの 1 回転ごとに同じになる。"],
    ["Once a turn: screw or its bearing running out, eccentric motor encoder, coupling out of line; several times a turn: pole pairs of motor or resolver; else the pitch of the scale.", "Einmal je Umdrehung: Schlag der Spindel oder ihres Lagers, exzentrischer Motorgeber, nicht fluchtende Kupplung; mehrmals je Umdrehung: Polpaare von Motor oder Resolver; sonst die Teilung des Maßstabs.", "1 回転に 1 回：ねじまたはその軸受の振れ、モータエンコーダの偏心、カップリングの心ずれ。1 回転に数回：モータまたはレゾルバの極対。それ以外：スケールのピッチ。"],
    ["A slow continuous move, or poses much closer than the lead.", "Eine langsame durchgehende Bewegung oder Stellungen, die viel dichter liegen als die Steigung.", "低速の連続移動、またはリードよりはるかに細かい間隔の姿勢。"],
    // clamp-shift
    ["The axis is pushed aside when its clamp or brake closes.", "Die Achse wird zur Seite gedrückt, wenn ihre Klemmung oder Bremse schließt.", "クランプまたはブレーキが閉じると軸が横に押される。"],
    ["Clamp or brake that does not pull evenly, drive that lets go before the clamp holds.", "Klemmung oder Bremse, die ungleichmäßig zieht; Antrieb, der loslässt, bevor die Klemmung hält.", "クランプまたはブレーキの効きが不均一。クランプが効く前に駆動が抜ける。"],
    ["The same poses at rest and in slow motion, or with the clamp switched off.", "Dieselben Stellungen im Stillstand und in langsamer Bewegung, oder mit abgeschalteter Klemmung.", "同じ姿勢を停止状態と低速運動で測る、またはクランプを切って測る。"],
    // component-errors
    ["The carriage leaves its ideal line and turns a little while it travels; the error is given for every position. Fewer than six places carry fewer orders.", "Der Schlitten verlässt beim Verfahren seine ideale Linie und dreht sich ein wenig; der Fehler ist für jede Position angegeben. Weniger als sechs Orte tragen weniger Ordnungen.", "キャリッジが移動中に理想の線から外れ、わずかに回転する。誤差は位置ごとに示す。測定位置が 6 か所未満なら次数も減る。"],
    ["Guideways, scale or screw; the course over the travel shows which.", "Führungen, Maßstab oder Spindel; der Verlauf über den Weg zeigt, was davon.", "案内面、スケール、またはねじ。移動に対する変化の形がどれかを示す。"],
    ["A measurement of the volume: tracking interferometer, ball plate, diagonals with other tests.", "Eine Messung des Arbeitsraums: nachführendes Interferometer, Kugelplatte, Diagonalen mit weiteren Prüfungen.", "空間全体の測定：追尾式干渉計、ボールプレート、対角線と他の試験の組合せ。"],
    // direction-shift
    ["The whole axis moves a little sideways or lengthways when it turns the other way.", "Die ganze Achse verschiebt sich ein wenig seitlich oder längs, wenn sie andersherum dreht.", "逆に回すと軸全体が横または軸方向にわずかにずれる。"],
    ["Bearing without enough preload, pushed by the worm or by friction.", "Lager mit zu wenig Vorspannung, von der Schnecke oder der Reibung verschoben.", "予圧の足りない軸受がウォームや摩擦に押される。"],
    ["Both directions of this axis at every pose.", "Beide Richtungen dieser Achse in jeder Stellung.", "すべての姿勢をこの軸の両方向で測る。"],
    // drive-pitch
    ["The axis runs ahead and behind in step with the teeth of its drive.", "Die Achse läuft im Takt der Zähne ihres Antriebs vor und nach.", "軸が駆動の歯に合わせて進み遅れする。"],
    ["Pitch error in the transmission (worm gear), or an inaccurate pitch error compensation table.", "Teilungsfehler im Getriebe (Schneckengetriebe) oder eine ungenaue Tabelle der Steigungsfehlerkompensation.", "伝達機構（ウォームギヤ）のピッチ誤差、または不正確なピッチ誤差補正表。"],
    ["A continuous slow turn, or poses much closer than a tooth.", "Eine langsame durchgehende Drehung oder Stellungen, die viel dichter liegen als ein Zahn.", "低速の連続回転、または 1 歯よりはるかに細かい間隔の姿勢。"],
    // encoder-eccentricity
    ["The axis turns a little too far and then too little, once or twice a turn.", "Die Achse dreht ein- oder zweimal je Umdrehung etwas zu weit und dann zu wenig.", "軸が 1 回転に 1 回または 2 回、わずかに回りすぎ、次に足りなくなる。"],
    ["Errors in the rotary encoder: disc mounted off centre or tilted, or one of two heads out of use.", "Fehler im Drehgeber: Scheibe exzentrisch oder schief montiert, oder einer von zwei Leseköpfen außer Betrieb.", "ロータリエンコーダの誤差：ディスクの偏心または傾き、2 個の読取ヘッドの一方の不動作。"],
    ["The axis turned over its whole range with the ball far from its line; another load separates it from gravity wind-up.", "Die Achse über ihren ganzen Bereich mit der Kugel weit von ihrer Linie gedreht; eine andere Last trennt es von der Verdrehung durch Schwerkraft.", "球を軸線から遠くに置き、全範囲で軸を回す。負荷を変えると重力によるねじれと分離できる。"],
    // gravity-sag
    ["The tilting frame or head and its drive give way under the weight, differently at every tilt.", "Schwenkrahmen oder Schwenkkopf und sein Antrieb geben unter dem Gewicht nach, bei jeder Neigung anders.", "傾斜フレームまたは傾斜ヘッドとその駆動が自重でたわみ、傾きごとに量が変わる。"],
    ["Deformation of the rotating unit and angular error of its positioning under gravity: an uneven stiffness of frame and bearings, missing counterbalance.", "Verformung der drehenden Einheit und Winkelfehler ihrer Positionierung unter Schwerkraft: ungleiche Steifigkeit von Rahmen und Lagern, fehlender Gewichtsausgleich.", "重力による回転ユニットの変形と位置決めの角度誤差：フレームと軸受の剛性の不均一、カウンタバランスの不足。"],
    ["Static poses over the whole tilt at two heights; another load on the table, or a heavier tool in the head, separates it from radial error motion and encoder error.", "Ruhende Stellungen über die ganze Neigung in zwei Höhen; eine andere Last auf dem Tisch oder ein schwereres Werkzeug im Kopf trennt es von radialem Bewegungsfehler und Geberfehler.", "傾きの全範囲を 2 つの高さで静的に測る。テーブルの負荷を変えるか、ヘッドの工具を重くすると、半径方向の運動誤差やエンコーダ誤差と分離できる。"],
    // inertial-deflection
    ["The machine bends while it accelerates or while an off-centre mass turns fast.", "Die Maschine biegt sich beim Beschleunigen oder wenn eine außermittige Masse schnell dreht.", "加速中、または偏心した質量が速く回るときに機械がたわむ。"],
    ["Mass above or next to the drive, soft drive train, unbalanced table.", "Masse über oder neben dem Antrieb, weicher Antriebsstrang, unausgewuchteter Tisch.", "駆動の上または横にある質量、剛性の低い駆動系、不釣合いなテーブル。"],
    ["Two feeds: the error grows fourfold when the feed doubles.", "Zwei Vorschübe: Der Fehler wächst auf das Vierfache, wenn der Vorschub sich verdoppelt.", "2 通りの送り速度：送りを 2 倍にすると誤差は 4 倍になる。"],
    // linear-scale
    ["The axis travels a little too far or too short over its whole length.", "Die Achse fährt über ihre ganze Länge etwas zu weit oder zu kurz.", "軸が全長にわたり、わずかに行きすぎるか足りない。"],
    ["Thermal growth of screw or scale, wrong scale factor, screw used as scale without compensation.", "Wärmedehnung von Spindel oder Maßstab, falscher Skalierungsfaktor, Spindel ohne Kompensation als Maßstab benutzt.", "ねじまたはスケールの熱膨張、スケール係数の誤り、補正なしでねじをスケールとして使用。"],
    ["Two ball radii or a bar of known length; temperature of screw or scale.", "Zwei Kugelradien oder ein Stab bekannter Länge; Temperatur von Spindel oder Maßstab.", "球の半径を 2 通りにする、または長さ既知のバーを使う。ねじまたはスケールの温度を測る。"],
    // location-errors
    ["The axis average line is not where, or not in the direction, that the control believes.", "Die mittlere Achslinie ist nicht dort oder nicht in der Richtung, die die Steuerung annimmt.", "軸平均線の位置または方向が、制御装置の想定と異なる。"],
    ["Assembly and alignment of the axes, or wrong pivot data in the control.", "Montage und Ausrichtung der Achsen oder falsche Drehpunktdaten in der Steuerung.", "軸の組立と芯出し、または制御装置の回転中心データの誤り。"],
    ["Any cycle that turns the axis; tilts need two heights.", "Jeder Zyklus, der die Achse dreht; Neigungen brauchen zwei Höhen.", "軸を回すサイクルなら何でもよい。傾きには 2 つの高さが必要。"],
    // nest-rotation
    ["The nest stands a little askew, so that a move in X also shows in Y.", "Das Nest steht etwas schief, sodass sich eine Bewegung in X auch in Y zeigt.", "ネストがわずかに斜めで、X の移動が Y にも現れる。"],
    ["Nest mounted by hand without alignment; not an error of the machine.", "Nest von Hand ohne Ausrichten montiert; kein Fehler der Maschine.", "ネストを手で、芯出しせずに取り付けた。機械の誤差ではない。"],
    ["Moving the ball by known steps along X, Y, Z (nest calibration).", "Die Kugel um bekannte Schritte entlang X, Y, Z bewegen (Nestkalibrierung).", "球を X、Y、Z に沿って既知の量だけ動かす（ネスト校正）。"],
    // probe-crosstalk
    ["A probe also shows a share of what its neighbour measures.", "Ein Messtaster zeigt auch einen Anteil dessen an, was sein Nachbar misst.", "変位計が隣の変位計の測る量の一部も示す。"],
    ["Cables or amplifiers that couple, eddy-current probes too close to each other, or a probe that leans towards another one; not an error of the machine.", "Kabel oder Verstärker, die koppeln, Wirbelstromsensoren zu dicht beieinander, oder ein Messtaster, der sich zu einem anderen neigt; kein Fehler der Maschine.", "ケーブルまたはアンプの結合、近すぎる渦電流式変位計、別の変位計の側へ傾いた変位計。機械の誤差ではない。"],
    ["Moving the ball by known steps along X, Y, Z (nest calibration): more than one probe moves.", "Die Kugel um bekannte Schritte entlang X, Y, Z bewegen (Nestkalibrierung): Mehr als ein Messtaster bewegt sich.", "球を X、Y、Z に沿って既知の量だけ動かす（ネスト校正）：複数の変位計が動く。"],
    // probe-gain
    ["The probes show a little too much or too little of every displacement.", "Die Messtaster zeigen von jeder Verschiebung etwas zu viel oder zu wenig an.", "変位計がどの変位もわずかに大きく、または小さく示す。"],
    ["Calibration of the probes out of date, or the wrong sensitivity in their file; not an error of the machine.", "Kalibrierung der Messtaster veraltet oder falsche Empfindlichkeit in ihrer Datei; kein Fehler der Maschine.", "変位計の校正が古い、またはファイルの感度が誤り。機械の誤差ではない。"],
    ["Moving the ball by known steps (nest calibration).", "Die Kugel um bekannte Schritte bewegen (Nestkalibrierung).", "球を既知の量だけ動かす（ネスト校正）。"],
    // probe-nonlinearity
    ["The probes show large displacements differently from small ones.", "Die Messtaster zeigen große Verschiebungen anders an als kleine.", "変位計が大きな変位を小さな変位とは異なる比率で示す。"],
    ["Probes used at the end of their range, or near a metal part (eddy current); not an error of the machine.", "Messtaster am Ende ihres Messbereichs oder nahe an einem Metallteil (Wirbelstrom); kein Fehler der Maschine.", "測定範囲の端での使用、または金属部品の近く（渦電流式）。機械の誤差ではない。"],
    ["Known steps of different size (nest calibration).", "Bekannte Schritte verschiedener Größe (Nestkalibrierung).", "大きさの異なる既知の移動（ネスト校正）。"],
    // radial-error-motion
    ["The axis line runs out sideways while it turns.", "Die Achslinie läuft beim Drehen seitlich aus.", "軸線が回転しながら横に振れる。"],
    ["Bearing run-out: out-of-round rings or rollers of unequal size.", "Lagerschlag: unrunde Ringe oder ungleich große Wälzkörper.", "軸受の振れ：軌道輪の真円度不良、転動体の寸法差。"],
    ["Turning the axis with the ball near its line, at two heights; a second ball radius separates n = 1 from a scale error.", "Die Achse mit der Kugel nahe ihrer Linie drehen, in zwei Höhen; ein zweiter Kugelradius trennt n = 1 von einem Maßstabsfehler.", "球を軸線の近くに置き、2 つの高さで軸を回す。球の半径をもう一つ加えると n = 1 をスケール誤差と分離できる。"],
    // reversal-spike
    ["The axis sticks for a moment when it turns round, then catches up.", "Die Achse haftet beim Umkehren einen Augenblick und holt dann auf.", "軸が反転時に一瞬止まり、その後追い付く。"],
    ["Friction at standstill (stick-slip) that the servo compensates too late: seals, guideways, missing friction compensation.", "Haftreibung (Stick-Slip), die der Servoantrieb zu spät ausgleicht: Dichtungen, Führungen, fehlende Reibungskompensation.", "静止摩擦（スティックスリップ）へのサーボの補償の遅れ：シール、案内面、摩擦補償の不足。"],
    ["On-the-fly circles through the reversal, at two feeds.", "Kreise in Bewegung durch die Umkehr, mit zwei Vorschüben.", "反転を通る運動中の円を、2 通りの送り速度で測る。"],
    // servo-lag
    ["One axis follows its command a little later than the others.", "Eine Achse folgt ihrem Sollwert etwas später als die anderen.", "一つの軸が他の軸よりわずかに遅れて指令に従う。"],
    ["Servo gain (Kv) or feed-forward not matched to the other axes.", "Servoverstärkung (Kv) oder Vorsteuerung nicht auf die anderen Achsen abgestimmt.", "サーボゲイン（Kv）またはフィードフォワードが他の軸と合っていない。"],
    ["Both directions and two feeds: the error flips with direction and doubles with the feed.", "Beide Richtungen und zwei Vorschübe: Der Fehler wechselt mit der Richtung das Vorzeichen und verdoppelt sich mit dem Vorschub.", "両方向と 2 通りの送り速度：誤差は方向で符号が変わり、送りに比例して 2 倍になる。"],
    // setup-slip
    ["The ball or the nest was moved during the measurement and stayed there.", "Kugel oder Nest wurde während der Messung verschoben und blieb dort.", "球またはネストが測定中に動き、そのままになった。"],
    ["Loose magnet or clamp, a knock, a collision, a cable that pulled; in the first minutes also a ball, nest or probe that settles after it was mounted. Not an error of the machine.", "Loser Magnet oder lose Klemmung, ein Stoß, eine Kollision, ein ziehendes Kabel; in den ersten Minuten auch eine Kugel, ein Nest oder ein Messtaster, der sich nach der Montage setzt. Kein Fehler der Maschine.", "磁石またはクランプの緩み、衝撃、衝突、引っ張るケーブル。最初の数分は取付け後の球・ネスト・変位計のなじみもある。機械の誤差ではない。"],
    ["Returning to the first pose before and after; mount it again, wait some minutes and repeat.", "Vorher und nachher zur ersten Stellung zurückkehren; neu montieren, einige Minuten warten und wiederholen.", "前後に最初の姿勢に戻る。取り付け直し、数分待って繰り返す。"],
    // spindle-growth
    ["The spindle gets longer while it warms up.", "Die Spindel wird beim Warmwerden länger.", "主軸が温まるにつれて伸びる。"],
    ["Heat of the spindle bearings and motor.", "Wärme der Spindellager und des Spindelmotors.", "主軸の軸受とモータの発熱。"],
    ["Returning to the first pose; only along the tool, unlike thermal drift of the frame.", "Zur ersten Stellung zurückkehren; nur entlang des Werkzeugs, anders als die thermische Drift des Gestells.", "最初の姿勢に戻る。フレームの熱ドリフトと異なり、工具の方向だけに現れる。"],
    // squareness
    ["Two linear axes do not meet at a right angle.", "Zwei Linearachsen stehen nicht im rechten Winkel zueinander.", "二つの直進軸が直角に交わっていない。"],
    ["Alignment of the guideways, or a machine standing unevenly on its feet.", "Ausrichtung der Führungen oder eine Maschine, die ungleich auf ihren Füßen steht.", "案内面の芯出し、または機械の据付けの不均等。"],
    ["A circle in the plane of the two axes (45° oval, the same in both directions); rotary cycles at two heights.", "Ein Kreis in der Ebene beider Achsen (Oval unter 45°, in beiden Richtungen gleich); Zyklen der Drehachsen in zwei Höhen.", "両軸の平面内の円（45° の楕円、両方向で同じ）。2 つの高さでの回転軸のサイクル。"],
    // stacked-tilt
    ["The upper axis wobbles more, or otherwise, when the lower axis is tilted.", "Die obere Achse taumelt stärker oder anders, wenn die untere Achse geneigt ist.", "下の軸が傾くと、上の軸の振れが大きく、または別の形になる。"],
    ["Bearing of the upper axis that gives way to the changing direction of the weight; out-of-round rings under load.", "Lager der oberen Achse, das unter der wechselnden Richtung des Gewichts nachgibt; unrunde Ringe unter Last.", "重量の方向の変化で上の軸の軸受がたわむ。負荷を受けた軌道輪の真円度不良。"],
    ["Whole turns of the upper axis at several tilts, two heights.", "Ganze Umdrehungen der oberen Achse bei mehreren Neigungen, zwei Höhen.", "複数の傾きで上の軸を 1 回転させる。2 つの高さ。"],
    // straightness
    ["The axis travels along a bow or an S instead of a straight line.", "Die Achse fährt auf einem Bogen oder einem S statt auf einer Geraden.", "軸が直線でなく、弓形または S 字に動く。"],
    ["Guideway bent by assembly, by its own weight or by heat.", "Führung durch Montage, Eigengewicht oder Wärme verbogen.", "組立、自重、または熱による案内面の曲がり。"],
    ["Poses all along the axis; other balls or bar lengths separate it from rotary errors.", "Stellungen über die ganze Achse; andere Kugeln oder Stablängen trennen es von Fehlern der Drehachsen.", "軸全長の姿勢。球またはバーの長さを変えると回転軸の誤差と分離できる。"],
    // sync-delay
    ["Rotary axes, linear axes and probes do not belong to the same instant.", "Drehachsen, Linearachsen und Messtaster gehören nicht zum selben Augenblick.", "回転軸・直進軸・変位計の値が同じ時刻のものでない。"],
    ["T_p: time on the way through control, network and probe electronics, not an error of the machine. T_r: interpolator, servo gains or feed-forward of rotary and linear axes not matched.", "T_p: Laufzeit durch Steuerung, Netz und Elektronik der Messtaster, kein Fehler der Maschine. T_r: Interpolator, Servoverstärkungen oder Vorsteuerung von Dreh- und Linearachsen nicht abgestimmt.", "T_p：制御装置・ネットワーク・変位計の電子回路を通る時間で、機械の誤差ではない。T_r：回転軸と直進軸の補間、サーボゲイン、フィードフォワードの不一致。"],
    ["Both directions of travel at two feeds: the error flips with direction and doubles with the feed.", "Beide Fahrtrichtungen mit zwei Vorschüben: Der Fehler wechselt mit der Richtung das Vorzeichen und verdoppelt sich mit dem Vorschub.", "両方向を 2 通りの送り速度で：誤差は方向で符号が変わり、送りに比例して 2 倍になる。"],
    // thermal-drift
    ["The machine grows while it warms up or cools down, and the tool wanders.", "Die Maschine dehnt sich beim Erwärmen oder Abkühlen, und das Werkzeug wandert.", "機械が温まりまたは冷えて伸縮し、工具の位置が移動する。"],
    ["Warm-up of spindle, drives and structure, or a change of the room or the coolant; with a time constant of a few minutes also a ball, nest or probe that settles after it was mounted.", "Erwärmung von Spindel, Antrieben und Gestell oder eine Änderung von Raum oder Kühlmittel; bei einer Zeitkonstante von wenigen Minuten auch eine Kugel, ein Nest oder ein Messtaster, der sich nach der Montage setzt.", "主軸・駆動・構造の温度上昇、または室温・切削液の変化。時定数が数分なら、取付け後の球・ネスト・変位計のなじみもある。"],
    ["Returning to the first pose, interleaved heights, waiting and repeating.", "Zur ersten Stellung zurückkehren, Höhen abwechseln, warten und wiederholen.", "最初の姿勢に戻る、高さを交互にする、待って繰り返す。"],
    // thermal-expansion
    ["The tool wanders with the temperature of a measured spot of the machine, at once or some time later.", "Das Werkzeug wandert mit der Temperatur einer gemessenen Stelle der Maschine, sofort oder etwas später.", "機械の温度測定点の温度とともに、すぐにまたは少し遅れて工具の位置が移動する。"],
    ["Expansion of structure, scales or screws; compensation off or with a wrong coefficient.", "Ausdehnung von Gestell, Maßstäben oder Spindeln; Kompensation aus oder mit falschem Koeffizienten.", "構造・スケール・ねじの膨張。補正が切れている、または係数が誤り。"],
    ["Temperatures recorded with the points, and a temperature that goes up and down.", "Mit den Punkten aufgezeichnete Temperaturen, und eine Temperatur, die steigt und fällt.", "測定点とともに記録した温度と、上下する温度。"],
    // tilt-error-motion
    ["The axis line wobbles like a top while it turns.", "Die Achslinie taumelt beim Drehen wie ein Kreisel.", "軸線が回転しながらこまのように振れる。"],
    ["Angular motion of the centre line: ring profile of the bearing, two bearings out of line, rollers of unequal size.", "Winkelbewegung der Achslinie: Ringprofil des Lagers, zwei nicht fluchtende Lager, ungleich große Wälzkörper.", "軸線の角度運動：軸受の軌道輪の形状、2 個の軸受の心ずれ、転動体の寸法差。"],
    ["Two heights of the ball: the wander grows with height.", "Zwei Höhen der Kugel: Das Auswandern wächst mit der Höhe.", "球を 2 つの高さに置く：ずれは高さとともに大きくなる。"],
    // unbalance
    ["A weight off the axis of the tilted table pulls it round, and over.", "Ein Gewicht neben der Achse des geneigten Tisches zieht ihn herum und kippt ihn.", "傾いたテーブルの軸から外れた重量が、テーブルを回し、倒す向きに引く。"],
    ["Workpiece or fixture off the centre; weak position loop or bearing of the table.", "Werkstück oder Vorrichtung außermittig; schwacher Lageregelkreis oder schwaches Lager des Tisches.", "工作物または治具の偏心。テーブルの位置ループまたは軸受の剛性不足。"],
    ["Turning C at several tilts B; with the load moved by 180° the sign flips.", "C bei mehreren Neigungen von B drehen; mit um 180° versetzter Last wechselt das Vorzeichen.", "B の複数の傾きで C を回す。負荷を 180° 移すと符号が変わる。"],
    // vibration
    ["Tool and table swing against each other in time, wherever the axes are.", "Werkzeug und Tisch schwingen mit der Zeit gegeneinander, wo immer die Achsen stehen.", "軸の位置にかかわらず、工具とテーブルが互いに振動する。"],
    ["Pumps, fans, spindle unbalance, neighbouring machines through the floor, or a control loop close to its limit.", "Pumpen, Lüfter, Spindelunwucht, Nachbarmaschinen über den Boden oder ein Regelkreis nahe seiner Grenze.", "ポンプ、ファン、主軸の不釣合い、床を伝わる隣の機械、または限界に近い制御ループ。"],
    ["Readings on the fly at two feeds: its frequency stays when the feed changes, those of screw, teeth and bearings do not; a recording with all axes at rest.", "Messwerte in Bewegung mit zwei Vorschüben: Seine Frequenz bleibt, wenn der Vorschub sich ändert, die von Spindel, Zähnen und Lagern nicht; eine Aufzeichnung mit ruhenden Achsen.", "2 通りの送り速度で運動中に測る：送りを変えてもその周波数は変わらず、ねじ・歯・軸受の周波数は変わる。全軸停止での記録。"],
    // Signs.
    ["the frame gives way more upright than lying on its side", "gibt der Rahmen aufrecht mehr nach als auf der Seite liegend", "フレームは横向きより直立でよくたわむ"],
    ["the frame gives way more lying on its side than upright", "gibt der Rahmen auf der Seite liegend mehr nach als aufrecht", "フレームは直立より横向きでよくたわむ"],
    ["the head or arm gives way more upright than lying on its side", "gibt der Kopf oder Arm aufrecht mehr nach als auf der Seite liegend", "ヘッドまたはアームは横向きより直立でよくたわむ"],
    ["the head or arm gives way more lying on its side than upright", "gibt der Kopf oder Arm auf der Seite liegend mehr nach als aufrecht", "ヘッドまたはアームは直立より横向きでよくたわむ"],
    ["By {}, {}: if that cannot be, weight was taken to act against gravity, and every location error is the other way round: make the sign test then, before anything is changed.", "Nach {} {}. Kann das nicht sein, so wurde das Gewicht entgegen der Schwerkraft gerechnet, und jede Lageabweichung hat das andere Vorzeichen: Dann den Vorzeichentest machen, bevor etwas geändert wird.", "{} によると、{}。それがあり得なければ重力の向きが逆に扱われており、すべての位置誤差の符号が逆になる。その場合は何も変更せず、まず符号テストを行う。"],
];
