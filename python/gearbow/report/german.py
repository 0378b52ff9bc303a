"""The German texts of a report: its own sentences, and words and sentences of results.

Terms are those of DIN 3960, DIN 743, DIN ISO 21940 and VDI 3839.
"""

#: Headings and sentences of the report, by the English ones.
GERMAN = {
    # Page
    "Summary": "Zusammenfassung",
    "Drawing": "Zeichnung",
    "Data and assumptions": "Daten und Annahmen",
    "Mass properties": "Massen und Trägheitsmomente",
    "Static loads": "Statische Belastung",
    "Natural modes": "Eigenschwingungen",
    "Campbell diagram": "Campbell-Diagramm",
    "Critical speeds": "Kritische Drehzahlen",
    "Resonances near the operating speed": "Resonanzen nahe der Betriebsdrehzahl",
    "Stability": "Stabilität",
    "Response to unbalance and bow": "Antwort auf Unwucht und Verkrümmung",
    "Strength of the shafts": "Festigkeit der Wellen",
    "Limits of the bow": "Grenzen der Verkrümmung",
    "Motion at the operating speed": "Bewegung bei Betriebsdrehzahl",
    "Accuracy and warnings": "Genauigkeit und Warnungen",
    "Reproduction": "Nachvollziehbarkeit",
    "The report was stopped. It lacks: {sections}.": (
        "Der Bericht wurde abgebrochen. Es fehlen: {sections}."
    ),
    "company": "Firma",
    "author": "Verfasser",
    "document number": "Dokumentnummer",
    "date": "Datum",
    "system": "System",
    "operating speed": "Betriebsdrehzahl",
    "speeds of diagrams": "Drehzahlen der Diagramme",
    "made": "erstellt",
    "save as {file}": "als {file} speichern",
    "{speed} ({other}), of the reference shaft": "{speed} ({other}), der Bezugswelle",
    "{low} to {high}": "{low} bis {high}",
    "{time} by gearbow {version}": "{time} mit gearbow {version}",
    "Made by gearbow {version} with Python {python} and NumPy {numpy} on {platform}.": (
        "Erstellt mit gearbow {version}, Python {python} und NumPy {numpy} auf {platform}."
    ),
    "Program (speeds in rad/s)": "Programm (Drehzahlen in rad/s)",
    "Scene": "Systemdatei",
    "Not computed: {reason}.": "Nicht berechnet: {reason}.",
    "Warning: {text}": "Warnung: {text}",
    "{title}: not complete, because {reason}.": "{title}: unvollständig, weil: {reason}.",
    "an unexpected {kind}: {error}": "unerwarteter Fehler {kind}: {error}",
    "no operating speed was given (operating=, or --speed)": (
        "es wurde keine Betriebsdrehzahl angegeben (operating= oder --speed)"
    ),
    "no speeds were given (speeds=, or --to)": (
        "es wurden keine Drehzahlen angegeben (speeds= oder --to)"
    ),
    "at standstill": "im Stillstand",
    "at {speed}": "bei {speed}",
    "stable": "stabil",
    "unstable": "instabil",
    "unstable ({kind})": "instabil ({kind})",
    # Bearings
    "Life of bearings": "Lebensdauer der Lager",
    "Basic rating life of the bearings.": "Nominelle Lebensdauer der Lager.",
    "No bearing is a rolling bearing or has a dynamic rating.": (
        "Kein Lager ist ein Wälzlager oder hat eine dynamische Tragzahl."
    ),
    "Shortest basic rating life: {hours} h, bearing {bearing}.": (
        "Kürzeste nominelle Lebensdauer: {hours} h, Lager {bearing}."
    ),
    # Drawing, data, masses
    "The train to scale; bows are enlarged.": (
        "Der Antriebsstrang maßstäblich; Verkrümmungen sind vergrößert."
    ),
    "Shafts and tooth frequencies": "Wellen und Zahneingriffsfrequenzen",
    "Shafts and tooth frequencies at {speed}": "Wellen und Zahneingriffsfrequenzen bei {speed}",
    "Values are those of the description; fields that are not listed have their defaults. "
    "x runs along the shafts; seen with +x towards the viewer, y points right and z up. "
    "Positions count from the left end of a shaft.": (
        "Die Werte sind die der Beschreibung; nicht aufgeführte Felder haben ihre Vorgabewerte. "
        "x verläuft entlang der Wellen; mit Blick gegen +x zeigt y nach rechts und z nach oben. "
        "Positionen zählen vom linken Wellenende."
    ),
    "Assumed where the description says nothing": ("Angenommen, wo die Beschreibung nichts angibt"),
    "Mass properties of the shafts with sleeves, gears and disks": (
        "Massen und Trägheitsmomente der Wellen mit Hülsen, Zahnrädern und Scheiben"
    ),
    "The polar inertia of all shafts, reduced to the reference shaft, is {inertia} kg m².": (
        "Das auf die Bezugswelle reduzierte Massenträgheitsmoment aller Wellen beträgt "
        "{inertia} kg m²."
    ),
    # Static loads
    "Static equilibrium": "Statisches Gleichgewicht",
    "Static equilibrium at {speed}": "Statisches Gleichgewicht bei {speed}",
    "Meshes at equilibrium": "Zahneingriffe im Gleichgewicht",
    "Largest static mesh force: {force}.": "Größte statische Zahnkraft: {force}.",
    "Static deflection of the shafts.": "Statische Durchbiegung der Wellen.",
    # Modes and Campbell diagram
    "Modes at {speed}": "Eigenschwingungen bei {speed}",
    "Modes at standstill": "Eigenschwingungen im Stillstand",
    "Shapes along the shafts.": "Eigenformen entlang der Wellen.",
    "Mode {number} in three dimensions, enlarged; the mouse turns and enlarges the view.": (
        "Eigenform {number} räumlich, vergrößert; die Maus dreht und vergrößert die Ansicht."
    ),
    "The diagram is that of positive speeds; it shades the size of the operating speed.": (
        "Das Diagramm gilt für positive Drehzahlen; grau ist der Betrag der Betriebsdrehzahl."
    ),
    "Campbell diagram. Grey: operating speed.": "Campbell-Diagramm. Grau: Betriebsdrehzahl.",
    "Intersections and stability thresholds": "Schnittpunkte und Stabilitätsgrenzen",
    "No line of excitation crosses a mode, and no mode changes its stability.": (
        "Keine Erregerlinie schneidet eine Eigenfrequenz, und keine Eigenschwingung ändert ihre "
        "Stabilität."
    ),
    # Critical speeds
    "Critical speeds of the Campbell diagram, with the amplification factor 1/(2ζ)": (
        "Kritische Drehzahlen des Campbell-Diagramms mit der Resonanzüberhöhung 1/(2ζ)"
    ),
    "No shaft excites a mode at its own frequency in this range of speeds.": (
        "In diesem Drehzahlbereich erregt keine Welle eine Eigenschwingung mit ihrer Drehfrequenz."
    ),
    "Peaks of {place}, excited by {shaft}": "Maxima an {place}, erregt durch {shaft}",
    "{place}: the response has no peak in this range of speeds.": (
        "{place}: Die Antwort hat in diesem Drehzahlbereich kein Maximum."
    ),
    "Separation margins after API RP 684: no peak of the response to bow and unbalance is too "
    "close to the operating speed.": (
        "Resonanzabstände nach API RP 684: Kein Maximum der Antwort auf Verkrümmung und Unwucht "
        "liegt zu nahe an der Betriebsdrehzahl."
    ),
    "Separation margins after API RP 684: peaks of the response to bow and unbalance that are too "
    "close to the operating speed, or unstable: {count}.": (
        "Resonanzabstände nach API RP 684: Maxima der Antwort auf Verkrümmung und Unwucht, die zu "
        "nahe an der Betriebsdrehzahl liegen oder instabil sind: {count}."
    ),
    "Required margin after API RP 684: 17 (1 − 1/(AF − 1.5)) % below and 10 % more above the "
    "operating speed; none for AF < 2.5.": (
        "Geforderter Abstand nach API RP 684: 17 (1 − 1/(AF − 1.5)) % unterhalb der "
        "Betriebsdrehzahl und 10 % mehr oberhalb; keiner für AF < 2.5."
    ),
    "No shaft excites a lightly damped mode at its own frequency.": (
        "Keine Welle erregt eine schwach gedämpfte Eigenschwingung mit ihrer Drehfrequenz."
    ),
    "Critical speeds [{unit}]: {speeds}.": "Kritische Drehzahlen [{unit}]: {speeds}.",
    "Nearest critical speeds [{unit}]: {speeds}.": (
        "Nächstgelegene kritische Drehzahlen [{unit}]: {speeds}."
    ),
    "The standard means lateral modes; unbalance and bow do not excite axial motion and, without "
    "teeth, no torsion. The response shows which of the speeds matter.": (
        "Die Norm meint Biegeschwingungen; Unwucht und Verkrümmung erregen keine Axialschwingung "
        "und ohne Verzahnung keine Torsion. Die Antwort zeigt, welche Drehzahlen wichtig sind."
    ),
    # Unbalance and level 1 of API 617
    "Unbalance placement of API 617: the system has no lateral motion.": (
        "Unwuchtanordnung nach API 617: Das System hat keine Querbewegung."
    ),
    "Unbalance placement of API 617: {shaft} has {lacks}.": (
        "Unwuchtanordnung nach API 617: {shaft} hat {lacks}."
    ),
    "no gear or disk as a plane": "kein Zahnrad und keine Scheibe als Ebene",
    "no mode of its own among {count}": "keine eigene Eigenform unter {count}",
    "{name} (opposite)": "{name} (gegenphasig)",
    "Unbalance of API 617, 2 · 6350 W/N, where the lowest mode of each shaft moves most": (
        "Unwucht nach API 617, 2 · 6350 W/N, wo die niedrigste Eigenform jeder Welle am größten ist"
    ),
    "Two planes of opposite motion have half of it each. The bows are left out.": (
        "Zwei gegenphasige Ebenen haben je die Hälfte. Die Verkrümmungen sind weggelassen."
    ),
    "Unbalance of API 617 on {shaft}: peaks of {place}": (
        "Unwucht nach API 617 auf {shaft}: Maxima an {place}"
    ),
    "Unbalance of API 617 on {shaft}: the response at {place} has no peak in this range.": (
        "Unwucht nach API 617 auf {shaft}: Die Antwort an {place} hat hier kein Maximum."
    ),
    "Vibration at the bearings with this unbalance, at the operating speed": (
        "Schwingungen an den Lagern mit dieser Unwucht bei Betriebsdrehzahl"
    ),
    "25.4 µm √(12000/N), at most 25.4 µm; of the shaft itself, not relative to a support.": (
        "25.4 µm √(12000/N), höchstens 25.4 µm; der Welle selbst, nicht relativ zum Lagerbock."
    ),
    "Stability level 1 of API 617": "Stabilität Stufe 1 nach API 617",
    "{name}: it is defined for one rotor, and this train has {count} shafts.": (
        "{name}: ist für einen Rotor definiert; dieser Strang hat {count} Wellen."
    ),
    "{name}: the rotor has {lacks}.": "{name}: Der Rotor hat {lacks}.",
    "no disk or gear": "keine Scheibe und kein Zahnrad",
    "no forward mode among {count}": "keine Gleichlaufform unter {count}",
    "{name}: the first forward mode is unstable without cross coupling.": (
        "{name}: Die erste Gleichlaufform ist ohne Koppelsteifigkeit instabil."
    ),
    "{name}: a cross-coupled stiffness at {body} does not remove the damping.": (
        "{name}: Eine Koppelsteifigkeit an {body} hebt die Dämpfung nicht auf."
    ),
    "{name}: logarithmic decrement of the first forward mode over a cross-coupled stiffness at "
    "{body}.": (
        "{name}: Logarithmisches Dekrement der ersten Gleichlaufform über der Koppelsteifigkeit an "
        "{body}."
    ),
    "Level 1 is passed up to an anticipated cross coupling Q_A of {largest} N/m": (
        "Stufe 1 ist bis zu einer erwarteten Koppelsteifigkeit Q_A von {largest} N/m erfüllt"
    ),
    "Level 1 is not passed even without cross coupling": (
        "Stufe 1 ist auch ohne Koppelsteifigkeit nicht erfüllt"
    ),
    "{name}: the decrement is {first} without cross coupling and zero at Q₀ = {zero} N/m. "
    "{passed} (Q₀/Q_A ≥ 2, decrement ≥ 0.1). Q_A follows from power, diameters and densities of "
    "the stages, which a scene does not have; the criterion of the gas density is not "
    "evaluated.": (
        "{name}: Das Dekrement ist {first} ohne Koppelsteifigkeit und null bei Q₀ = {zero} N/m. "
        "{passed} (Q₀/Q_A ≥ 2, Dekrement ≥ 0.1). Q_A folgt aus Leistung, Durchmessern und Dichten "
        "der Stufen, die das System nicht enthält; das Kriterium der Gasdichte ist nicht "
        "ausgewertet."
    ),
    # Resonances
    "Orders of shafts and teeth are compared with the modes up to {frequency} Hz, from {low} to "
    "{high}: API RP 684 requires margins of up to {below} % below and {above} % above the "
    "operating speed.": (
        "Drehfrequenzen und Zahneingriffsfrequenzen sind mit den Eigenfrequenzen bis {frequency} Hz"
        " von {low} bis {high} verglichen: API RP 684 fordert Abstände bis {below} % unterhalb und "
        "{above} % oberhalb der Betriebsdrehzahl."
    ),
    "Teeth reach {frequency} Hz; modes above {highest} Hz are not compared.": (
        "Zahneingriffsfrequenzen reichen bis {frequency} Hz; Eigenfrequenzen über {highest} Hz sind"
        " nicht verglichen."
    ),
    "Modes that orders of shafts and teeth meet near the operating speed": (
        "Eigenschwingungen, die Wellen- und Zahnordnungen nahe der Betriebsdrehzahl treffen"
    ),
    "Distance: from the operating speed, 0 within its range. Response at the resonance: largest "
    "orbit by bow and unbalance (major semi-axis), or mesh force by a transmission error of 1 µm; "
    "none without damping.": (
        "Abstand: von der Betriebsdrehzahl, 0 in ihrem Bereich. Antwort in der Resonanz: größte "
        "Wellenbahn durch Verkrümmung und Unwucht (große Halbachse) oder Zahnkraft durch eine "
        "Drehwegabweichung von 1 µm; keine ohne Dämpfung."
    ),
    "The nearest resonance: {source} meets mode {mode} ({frequency} Hz) {distance} % beside the "
    "operating speed.": (
        "Nächstgelegene Resonanz: {source} trifft Eigenform {mode} ({frequency} Hz) {distance} % "
        "neben der Betriebsdrehzahl."
    ),
    "No order of shafts or teeth meets a mode (up to {frequency} Hz) from {low} to {high}.": (
        "Keine Wellen- oder Zahnordnung trifft von {low} bis {high} eine Eigenfrequenz (bis "
        "{frequency} Hz)."
    ),
    "No order of shafts or teeth meets a mode in this range of speeds.": (
        "Keine Wellen- oder Zahnordnung trifft in diesem Drehzahlbereich eine Eigenfrequenz."
    ),
    "Margins of these modes after API RP 684": "Abstände dieser Eigenschwingungen nach API RP 684",
    "The standard means lateral modes and orders of shafts; teeth are listed alike.": (
        "Die Norm meint Biegeschwingungen und Wellenordnungen; Zahnordnungen sind ebenso bewertet."
    ),
    # Stability
    "Logarithmic decrement {where}": "Logarithmisches Dekrement {where}",
    "Of the motion about the static equilibrium, linearised with mean mesh stiffnesses and with "
    "the coefficients of the bearings at this speed.": (
        "Der Bewegung um das statische Gleichgewicht, linearisiert mit mittleren "
        "Eingriffssteifigkeiten und den Lagerkoeffizienten bei dieser Drehzahl."
    ),
    "The linear motion {where} is {state}.": "Die lineare Bewegung {where} ist {state}.",
    "No mode has damping: resonances have no finite amplitude.": (
        "Keine Eigenschwingung ist gedämpft: Resonanzen haben keine endliche Amplitude."
    ),
    "The motion {where} is {state}: {growing} of {count} modes grow.": (
        "Die Bewegung {where} ist {state}: {growing} von {count} Eigenschwingungen wachsen an."
    ),
    "Speeds at which a mode is unstable: {speeds}.": (
        "Drehzahlen, bei denen eine Eigenschwingung instabil ist: {speeds}."
    ),
    "No mode of the Campbell diagram is unstable in its range of speeds.": (
        "Keine Eigenschwingung des Campbell-Diagramms ist in seinem Drehzahlbereich instabil."
    ),
    # Response
    "There is no response to bow and unbalance: {reason}.": (
        "Es gibt keine Antwort auf Verkrümmung und Unwucht: {reason}."
    ),
    "no shaft has a bow and no body an unbalance": (
        "keine Welle ist verkrümmt und kein Körper hat eine Unwucht"
    ),
    "the system has no lateral motion": "das System hat keine Querbewegung",
    "Phase and amplitude (major semi-axis) where the orbits are largest; AF: amplification "
    "factor.": (
        "Phase und Amplitude (große Halbachse) an den Orten der größten Wellenbahnen; AF: "
        "Resonanzüberhöhung."
    ),
    "Major semi-axis of the orbit that the own shaft excites at {speed}": (
        "Große Halbachse der Wellenbahn, die die eigene Welle bei {speed} erregt"
    ),
    "Phase: angle of the high spot in the shaft, from its mark at angle 0.": (
        "Phase: Winkel der hohen Stelle in der Welle, von ihrer Marke beim Winkel 0."
    ),
    # Strength
    "The worst section of each shaft": "Der höchstbeanspruchte Querschnitt jeder Welle",
    "Nominal stresses of the turning shafts by the static equilibrium, bow and unbalance; ± is the "
    "amplitude. The equivalent amplitude has the notch factors (bending / torsion).": (
        "Nennspannungen der umlaufenden Wellen durch statisches Gleichgewicht, Verkrümmung und "
        "Unwucht; ± ist der Ausschlag. Der Vergleichsausschlag enthält die Kerbwirkungszahlen "
        "(Biegung / Torsion)."
    ),
    "Excitations that are not contained: {names}.": "Nicht enthaltene Erregungen: {names}.",
    "Sections at a step of the diameter without notch factors: {count}. Their real stresses are "
    "larger.": (
        "Querschnitte an Durchmesserstufen ohne Kerbwirkungszahlen: {count}. Ihre wirklichen "
        "Spannungen sind größer."
    ),
    "Equivalent stresses along the shafts.": "Vergleichsspannungen entlang der Wellen.",
    "Largest stress: amplitude {amplitude} MPa, mean {mean} MPa, {shaft} at {position} mm (no "
    "endurance limit was given).": (
        "Größte Spannung: Ausschlag {amplitude} MPa, Mittelspannung {mean} MPa, {shaft} bei "
        "{position} mm (keine Dauerfestigkeit angegeben)."
    ),
    "Largest utilisation of a shaft: {use} (amplitude {amplitude} MPa, mean {mean} MPa, {shaft} at "
    "{position} mm).": (
        "Größte Auslastung einer Welle: {use} (Ausschlag {amplitude} MPa, Mittelspannung {mean} "
        "MPa, {shaft} bei {position} mm)."
    ),
    # Bow
    "A bow has no effect: the system has no lateral motion.": (
        "Eine Verkrümmung hat keine Wirkung: Das System hat keine Querbewegung."
    ),
    "{shaft}: not computed, because {reason}": "{shaft}: nicht berechnet, weil: {reason}",
    "Limits of the bow of {shaft}: {reason}.": "Grenzen der Verkrümmung von {shaft}: {reason}.",
    "Limits of the bow of {shaft} at {speed}; present bow {bow} µm": (
        "Grenzen der Verkrümmung von {shaft} bei {speed}; vorhandene Verkrümmung {bow} µm"
    ),
    "Bow of {shaft}: {present} µm of at most {most} µm, by the limit {limit} ({at}).": (
        "Verkrümmung von {shaft}: {present} µm von höchstens {most} µm, Grenze: {limit} ({at})."
    ),
    "above the diameter of the shaft, {diameter} mm": (
        "über dem Durchmesser der Welle, {diameter} mm"
    ),
    "No bow of {shaft} up to its diameter reaches a limit.": (
        "Keine Verkrümmung von {shaft} bis zum Durchmesser erreicht eine Grenze."
    ),
    "The value of API 617 for the vibration of a shaft, 25.4 µm √(12000/n), is a reference at each "
    "bearing; whether the standard applies to this machine is for its user to decide. Bows above "
    "the largest diameter of the shaft are no limits: the shaft is destroyed before.": (
        "Der Wert der API 617 für Wellenschwingungen, 25.4 µm √(12000/n), ist ein Bezugswert an "
        "jedem Lager; ob die Norm für diese Maschine gilt, entscheidet der Anwender. Verkrümmungen "
        "über dem größten Durchmesser der Welle sind keine Grenzen: Die Welle ist vorher zerstört."
    ),
    # Motion
    "Motion at {speed}: {what}.": "Bewegung bei {speed}: {what}.",
    "the steady state, {method}, period {period}, residual {residual}": (
        "eingeschwungener Zustand, {method}, Periode {period}, Residuum {residual}"
    ),
    "none in common": "keine gemeinsame",
    "a run over {angle}° of the reference shaft, as a mode has no damping, so that nothing "
    "settles; give bearings and meshes damping": (
        "ein Lauf über {angle}° der Bezugswelle, weil eine Eigenschwingung ungedämpft ist und "
        "nichts einschwingt; Lager und Zahneingriffe brauchen Dämpfung"
    ),
    "a run of {count} revolutions of the slowest shaft, because {reason}": (
        "ein Lauf über {count} Umdrehungen der langsamsten Welle, weil: {reason}"
    ),
    "Recorded signals": "Aufgezeichnete Signale",
    "Accelerations at the sensors of the housings": (
        "Beschleunigungen an den Messstellen der Gehäuse"
    ),
    "Largest accelerations of gears and disks": (
        "Größte Beschleunigungen der Zahnräder und Scheiben"
    ),
    "{order}: {size} m/s²; rest {rest} %": "{order}: {size} m/s²; Rest {rest} %",
    "Largest order: amplitude; the rest is the part of the RMS that orders of shafts and teeth do "
    "not contain.": (
        "Größte Ordnung: Amplitude; der Rest ist der Teil des Effektivwerts, den Wellen- und "
        "Zahnordnungen nicht enthalten."
    ),
    "Orbits: {names}.": "Wellenbahnen: {names}.",
    "Amplitude spectra of the places with the largest motion.": (
        "Amplitudenspektren der Orte mit der größten Bewegung."
    ),
    "Twist of gears and disks.": "Verdrehung der Zahnräder und Scheiben.",
    "Force, deflection and stiffness: {names}.": "Kraft, Verformung und Steifigkeit: {names}.",
    "Mesh geometry at the moving centres: {names}.": (
        "Verzahnungsgeometrie an den bewegten Mittelpunkten: {names}."
    ),
    "There is no mesh geometry: the system has no gears in mesh.": (
        "Keine Verzahnungsgeometrie: Das System hat keine Zahneingriffe."
    ),
    "Bearing forces: {names}.": "Lagerkräfte: {names}.",
    "Whether small disturbances of this motion decay follows from the eigenvalues in the section "
    "on stability: no teeth change the stiffness of the system.": (
        "Ob kleine Störungen dieser Bewegung abklingen, folgt aus den Eigenwerten im Abschnitt zur "
        "Stabilität: Keine Zähne ändern die Steifigkeit des Systems."
    ),
    "The steady state is {state}.": "Der eingeschwungene Zustand ist {state}.",
    "The steady state is stable: the motion ran in, so that disturbances decay.": (
        "Der eingeschwungene Zustand ist stabil: Die Bewegung schwang ein, Störungen klingen ab."
    ),
    "Stability of the steady state: not computed, because {reason}": (
        "Stabilität des eingeschwungenen Zustands: nicht berechnet, weil: {reason}"
    ),
    "Floquet multipliers over {section}, with the changing stiffness of the teeth: {size}.": (
        "Floquet-Multiplikatoren über {section} mit der veränderlichen Zahnsteifigkeit: {size}."
    ),
    "a part of the motion": "einen Teil der Bewegung",
    "a period": "eine Periode",
    "the largest is {size}": "der größte ist {size}",
    "all are below {least}": "alle liegen unter {least}",
    # Accuracy
    "Elements": "Elemente",
    "Residuals of the equations": "Residuen der Gleichungen",
    "static equilibrium: unbalanced part of the load": (
        "statisches Gleichgewicht: unausgeglichener Teil der Last"
    ),
    "modes: part of the forces, largest": "Eigenschwingungen: Teil der Kräfte, größter",
    "critical speeds and tooth resonances, largest": (
        "kritische Drehzahlen und Zahnresonanzen, größtes"
    ),
    "response to bow and unbalance: backward error, largest": (
        "Antwort auf Verkrümmung und Unwucht: Rückwärtsfehler, größter"
    ),
    "Warnings": "Warnungen",
    "There were no warnings.": "Es gab keine Warnungen.",
}

#: Words, names of quantities, and sentences that results, parts and figures bring along.
WORDS = {
    # Quantities and headings of tables
    "shaft": "Welle",
    "speed ratio": "Übersetzung",
    "gears (teeth)": "Räder (Zähne)",
    "tooth frequency": "Zahneingriffsfrequenz",
    "tooth frequency / speed": "Zahneingriffsfrequenz / Drehzahl",
    "speed": "Drehzahl",
    "parts": "Teile",
    "assumption": "Annahme",
    "mass": "Masse",
    "inertia xx": "Trägheitsmoment xx",
    "inertia yy": "Trägheitsmoment yy",
    "inertia zz": "Trägheitsmoment zz",
    "machine": "Maschine",
    "place": "Ort",
    "force": "Kraft",
    "axial force": "Axialkraft",
    "displacement y": "Verschiebung y",
    "displacement z": "Verschiebung z",
    "displacement": "Verschiebung",
    "mesh deflection": "Verformung im Eingriff",
    "mesh": "Zahneingriff",
    "thrust": "Axialkraft",
    "stiffness": "Steifigkeit",
    "pressure angle": "Eingriffswinkel",
    "centre distance": "Achsabstand",
    "contact ratio": "Überdeckung",
    "mode": "Eigenform",
    "frequency": "Frequenz",
    "damping": "Dämpfung",
    "damping ratio": "Dämpfungsgrad",
    "whirl": "Bewegungsform",
    "largest motion": "größte Bewegung",
    "excited by": "erregt durch",
    "critical speed": "kritische Drehzahl",
    "amplification factor": "Resonanzüberhöhung",
    "margin": "Abstand",
    "required margin": "geforderter Abstand",
    "verdict": "Bewertung",
    "amplitude": "Amplitude",
    "mass W": "Masse W",
    "speed N": "Drehzahl N",
    "planes": "Ebenen",
    "unbalance": "Unwucht",
    "bearing": "Lager",
    "peak-to-peak": "Spitze-Spitze",
    "limit of API 617": "Grenze nach API 617",
    "within": "eingehalten",
    "yes": "ja",
    "no": "nein",
    "order": "Ordnung",
    "distance": "Abstand",
    "response": "Antwort",
    "decrement": "Dekrement",
    "bow and unbalance": "Verkrümmung und Unwucht",
    "bow": "Verkrümmung",
    "phase": "Phase",
    "position": "Position",
    "bending mean": "Biegung Mittel",
    "bending ±": "Biegung ±",
    "axial mean": "axial Mittel",
    "axial ±": "axial ±",
    "torsion mean": "Torsion Mittel",
    "torsion ±": "Torsion ±",
    "equivalent mean": "Vergleich Mittel",
    "equivalent ±": "Vergleich ±",
    "notch": "Kerbe",
    "utilisation": "Auslastung",
    "limit": "Grenze",
    "at": "an",
    "why": "warum",
    "peak": "Spitzenwert",
    "RMS": "Effektivwert",
    "largest order": "größte Ordnung",
    "signal": "Signal",
    "mean": "Mittelwert",
    "smallest": "kleinster",
    "largest": "größter",
    "unit": "Einheit",
    "elements of its segments": "Elemente der Abschnitte",
    "degree": "Grad",
    "result": "Ergebnis",
    "residual": "Residuum",
    "section": "Abschnitt",
    "warning": "Warnung",
    "file": "Datei",
    "description": "Beschreibung",
    # Words in cells
    "forward": "Gleichlauf",
    "backward": "Gegenlauf",
    "mixed": "gemischt",
    "planar": "eben",
    "torsion": "Torsion",
    "axial": "axial",
    "coupled": "gekoppelt",
    "rigid": "starr",
    "rigid-body rotation": "Starrkörperdrehung",
    "rigid motion of {name}": "Starrkörperbewegung von {name}",
    "acceptable": "zulässig",
    "critically damped": "stark gedämpft",
    "too close": "zu nahe",
    "unstable": "instabil",
    "no operating speed": "keine Betriebsdrehzahl",
    "unknown": "unbekannt",
    "linear": "linear",
    "nonlinear": "nichtlinear",
    "quasi-periodic": "quasiperiodisch",
    "flutter": "Flattern",
    "divergence": "Divergenz",
    "period doubling": "Periodenverdopplung",
    "none given": "nicht angegeben",
    "tips touch roots": "Kopf berührt Fuß",
    "involutes end": "Evolventen enden",
    "backlash used up": "Flankenspiel aufgebraucht",
    "velocity": "Geschwindigkeit",
    "bearing life": "Lagerlebensdauer",
    "stress": "Spannung",
    "mesh force": "Zahnkraft",
    "tip and root circles touch": "Kopf- und Fußkreise berühren sich",
    "a tip reaches the base circle of the other gear": (
        "ein Zahnkopf erreicht den Grundkreis des Gegenrads"
    ),
    "contact ratio below {least}": "Überdeckung unter {least}",
    "the mesh has no backlash": "der Zahneingriff hat kein Flankenspiel",
    "back flanks touch: backlash {size} µm": "Rückflanken berühren sich: Flankenspiel {size} µm",
    "the bow moves these gears by less than {part} of its size": (
        "die Verkrümmung bewegt diese Räder um weniger als {part} ihrer Größe"
    ),
    "the base circles overlap first, at {bow} µm": (
        "vorher überdecken sich die Grundkreise, bei {bow} µm"
    ),
    "{reason}; exceeded without this bow": "{reason}; ohne diese Verkrümmung überschritten",
    "{size} µm peak-to-peak": "{size} µm Spitze-Spitze",
    "no bow reaches a limit": "keine Verkrümmung erreicht eine Grenze",
    "decides: {limit}, {at}, at {bow} µm": "maßgebend: {limit}, {at}, bei {bow} µm",
    "peak {number}: {missing}, because the amplitude stays above 1/√2 of the peak {where}": (
        "Maximum {number}: {missing}, weil die Amplitude über 1/√2 des Maximums bleibt, {where}"
    ),
    "no N₁": "kein N₁",
    "no N₂": "kein N₂",
    "no N₁ and N₂": "kein N₁ und N₂",
    "from standstill or the lowest speed to the peak": (
        "vom Stillstand oder der kleinsten Drehzahl bis zum Maximum"
    ),
    "from the peak to the last speed; give speeds beyond it": (
        "vom Maximum bis zur letzten Drehzahl; höhere Drehzahlen angeben"
    ),
    "at all speeds on both sides; give more speeds": (
        "bei allen Drehzahlen auf beiden Seiten; mehr Drehzahlen angeben"
    ),
    "excitation left out: {names}": "nicht enthaltene Erregung: {names}",
    "run-out of gears": "Rundlaufabweichung der Räder",
    "run-out of couplings": "Rundlaufabweichung der Kupplungen",
    "forces of order 1": "Kräfte der Ordnung 1",
    "forces of other orders": "Kräfte anderer Ordnungen",
    "transmission errors of order 1": "Drehwegabweichungen der Ordnung 1",
    "other transmission errors": "andere Drehwegabweichungen",
    "loads over time": "zeitveränderliche Lasten",
    "itself: {state} above": "selbst: darüber {state}",
    "{harmonic}× teeth of {mesh}": "{harmonic}× Zähne von {mesh}",
    "{harmonic}× mesh {mesh}": "{harmonic}× Eingriff {mesh}",
    "mesh {mesh}": "Eingriff {mesh}",
    "bearing {place} force": "Lager {place} Kraft",
    "bearing {place}": "Lager {place}",
    "{place} contact ratio": "{place} Überdeckung",
    "{place} force": "{place} Kraft",
    "twist of {shaft} and {other}": "Verdrehung von {shaft} und {other}",
    "twist of {shaft}": "Verdrehung von {shaft}",
    "{shaft} y and z": "{shaft} y und z",
    "{shaft} at {place} m": "{shaft} bei {place} m",
    "{shaft} at {place} m {axis}": "{shaft} bei {place} m {axis}",
    "{shaft} at {place} mm": "{shaft} bei {place} mm",
    "{count} degrees of freedom.": "{count} Freiheitsgrade.",
    "{level}: expected error {error}, at most {most}; frequencies up to {frequency} Hz are accurate"
    " to {accuracy}.": (
        "{level}: erwarteter Fehler {error}, höchstens {most}; Frequenzen bis {frequency} Hz sind "
        "auf {accuracy} genau."
    ),
    "Engineering": "Stufe Engineering",
    # Parts and their fields
    "shafts": "Wellen",
    "gears": "Zahnräder",
    "disks": "Scheiben",
    "meshes": "Zahneingriffe",
    "bearings": "Lager",
    "supports": "Lagerböcke",
    "housings": "Gehäuse",
    "couplings": "Kupplungen",
    "drives": "Antriebe",
    "torques": "Drehmomente",
    "forces": "Kräfte",
    "sleeves": "Hülsen",
    "notches": "Kerben",
    "Journal bearings": "Gleitlager",
    "Rolling bearings": "Wälzlager",
    "Options": "Optionen",
    "Segments of {parts}, from left to right": "Abschnitte der {parts}, von links nach rechts",
    "option": "Option",
    "value": "Wert",
    "of": "von",
    "name": "Name",
    "material": "Werkstoff",
    "length": "Länge",
    "outer diameter": "Außendurchmesser",
    "inner diameter": "Innendurchmesser",
    "end outer diameter": "Außendurchmesser am Ende",
    "end inner diameter": "Innendurchmesser am Ende",
    "elements": "Elemente",
    "internal damping": "innere Dämpfung",
    "begin": "Anfang",
    "end": "Ende",
    "teeth": "Zähnezahl",
    "module": "Modul",
    "face width": "Zahnbreite",
    "helix angle": "Schrägungswinkel",
    "profile shift": "Profilverschiebung",
    "base radius": "Grundkreisradius",
    "tip radius": "Kopfkreisradius",
    "hand": "Flankenrichtung",
    "runout": "Rundlaufabweichung",
    "diametral inertia": "äquatoriales Trägheitsmoment",
    "polar inertia": "polares Trägheitsmoment",
    "inertia": "Trägheitsmoment",
    "driver": "treibend",
    "driven": "getrieben",
    "centre line angle": "Winkel der Mittenlinie",
    "backlash": "Flankenspiel",
    "error": "Verzahnungsabweichung",
    "friction": "Reibung",
    "kind": "Bauart",
    "boundary": "Hauptmaße",
    "support": "Abstützung",
    "contact angle": "Druckwinkel",
    "degrees of freedom": "Freiheitsgrade",
    "designation": "Bezeichnung",
    "axial stiffness": "Axialsteifigkeit",
    "axial damping": "Axialdämpfung",
    "tilting stiffness": "Kippsteifigkeit",
    "tilting damping": "Kippdämpfung",
    "rotational stiffness": "Drehsteifigkeit",
    "rotational damping": "Drehdämpfung",
    "torsional stiffness": "Torsionssteifigkeit",
    "torsional damping": "Torsionsdämpfung",
    "lateral stiffness": "Quersteifigkeit",
    "lateral damping": "Querdämpfung",
    "loss factor": "Verlustfaktor",
    "foundation": "Fundament",
    "points": "Punkte",
    "angle": "Winkel",
    "diameter": "Durchmesser",
    "clearance": "Spiel",
    "viscosity": "Viskosität",
    "load": "Last",
    "balance": "Gleichgewicht",
    "reference": "Bezugswelle",
    "gravity": "Erdbeschleunigung",
    "modal damping": "modale Dämpfung",
    "rayleigh": "Rayleigh-Dämpfung",
    "accuracy": "Genauigkeit",
    "bending": "Biegung",
    "shape": "Form",
    "model": "Modell",
    "half sine": "Halbsinus",
    "potential energy": "potentielle Energie",
    "deep groove": "Rillenkugellager",
    "angular contact": "Schrägkugellager",
    "cylindrical roller": "Zylinderrollenlager",
    "tapered roller": "Kegelrollenlager",
    "needle cage": "Nadelkranz",
    "Young's modulus": "Elastizitätsmodul",
    "Poisson's ratio": "Querkontraktionszahl",
    "density": "Dichte",
    "tooth": "Zahn",
    "film": "Schmierfilm",
    "offset": "Versatz",
    "element diameter": "Wälzkörperdurchmesser",
    "pitch diameter": "Teilkreisdurchmesser",
    "roller length": "Rollenlänge",
    "contact": "Kontakt",
    "short": "kurz",
    "finite": "endlich",
    "plain": "glatt",
    # Assumptions
    "steel with E = 207 GPa, ν = 0.3, ρ = 7850 kg/m³": (
        "Stahl mit E = 207 GPa, ν = 0.3, ρ = 7850 kg/m³"
    ),
    "mass and inertia of steel rings": "Masse und Trägheitsmoment von Stahlringen",
    "tip radius of full-depth teeth": "Kopfkreisradius von Zähnen voller Höhe",
    "mass and inertia of solid steel disks": ("Masse und Trägheitsmoment von vollen Stahlscheiben"),
    "number and size of rolling elements by estimates, stiffness within {error}": (
        "Zahl und Größe der Wälzkörper geschätzt, Steifigkeit auf {error}"
    ),
    "mean stiffness of ISO 6336-1": "mittlere Steifigkeit nach ISO 6336-1",
    "tooth pairs engage over {part} of the base pitch": (
        "Zahnpaare kommen über {part} der Grundkreisteilung in Eingriff"
    ),
    "no damping": "keine Dämpfung",
    "contact on both flanks, without backlash": "Kontakt an beiden Flanken, ohne Spiel",
    "no damping in separation": "keine Dämpfung bei abgehobenen Flanken",
    # Figures
    "speed of the reference shaft": "Drehzahl der Bezugswelle",
    "time": "Zeit",
    "operating speed": "Betriebsdrehzahl",
    "intersection": "Schnittpunkt",
    "stability threshold": "Stabilitätsgrenze",
    "cross-coupled stiffness": "Koppelsteifigkeit",
    "logarithmic decrement": "logarithmisches Dekrement",
    "equivalent stress": "Vergleichsspannung",
    "amplitude, with notch factors": "Ausschlag, mit Kerbwirkungszahlen",
    "deflection": "Verformung",
    "own scale": "eigener Maßstab",
    "last turn": "letzte Umdrehung",
    "orbit": "Wellenbahn",
    "twist": "Verdrehung",
    "position on {shaft} [m]": "Position auf {shaft} [m]",
    "side view, bow × {factor}": "Seitenansicht, Verkrümmung × {factor}",
    "side view": "Seitenansicht",
    "end view, seen along −x": "Stirnansicht in Richtung −x",
}
