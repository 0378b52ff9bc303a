"""Values of standards and catalogues, typed a second time, apart from those of the package.

Each value has its source. A test compares every table of the package with the one here; a value that differs is wrong in one of
the two places.
"""

from __future__ import annotations

import math

#: RMS velocity of the housing at the zone boundaries A/B, B/C and C/D [mm/s] by group and foundation: ISO 20816-3:2022, tables
#: A.1 (group 1, above 300 kW) and A.2 (group 2, 15 kW to 300 kW); the same as in ISO 10816-3:2009.
ZONES_OF_VELOCITY = {
    ("group 1", "rigid"): [2.3, 4.5, 7.1],
    ("group 1", "flexible"): [3.5, 7.1, 11.0],
    ("group 2", "rigid"): [1.4, 2.8, 4.5],
    ("group 2", "flexible"): [2.3, 4.5, 7.1],
}
#: Peak-to-peak displacement of the shaft at the zone boundaries times the root of the speed [µm √rpm]: ISO 20816-3, annex on shaft
#: vibration; the same as in ISO 7919-3:2009.
ZONES_OF_DISPLACEMENT = {"A/B": 4800.0, "B/C": 9000.0, "C/D": 13200.0}
#: API 617, 7th edition (2002), 2.6.8.8: 25.4 µm √(12000/N), and 25.4 µm at most.
API_617_AT_3000_RPM, API_617_MOST = 50.8e-6, 25.4e-6
#: Unbalance of one correction plane, 6350 W/N [g mm] with W [kg] and N [rpm]: API 617 (2002), 2.6.2.7.
API_617_UNBALANCE = 6350.0
#: Exponents of the life and turns at the basic rating: ISO 281:2007, 5.1 and 7.1.
LIFE_OF_BALLS, LIFE_OF_ROLLERS, RATED_TURNS = 3.0, 10.0 / 3.0, 1e6

#: Balance quality grades: the product of permissible eccentricity and speed [mm/s]. ISO 21940-11:2016, 7.2 and table 1.
BALANCE_GRADES = [0.4, 1.0, 2.5, 6.3, 16.0, 40.0, 100.0, 250.0, 630.0, 1600.0, 4000.0]

_TENS = "10 12 15 17 20 25 30 35 40 45 50 55 60 65 70 75 80 85 90 95 100 105 110 120 130 140 150"


def _boundary(prefix: str, outer: str, width: str, bores: str = _TENS) -> dict[str, list[float]]:
    """Give bore, outside diameter and width [mm] by designation."""
    small = {10: "00", 12: "01", 15: "02", 17: "03"}
    rows = [[float(x) for x in text.split()] for text in (bores, outer, width)]
    return {
        prefix + small.get(int(d), f"{int(d) // 5:02d}"): [d, big, wide]
        for d, big, wide in zip(*rows, strict=True)
    }


#: Outside diameters and widths of ISO 15:2017, clause 5, dimension series 10, 02 and 03, from 10 mm to 150 mm; the widths T of
#: tapered roller bearings 320..X are those of ISO 355:2019, clause 6.
_OUTER_02 = "30 32 35 40 47 52 62 72 80 85 90 100 110 120 125 130 140 150 160 170 180 190 200 215 230 250 270"
_WIDTH_02 = "9 10 11 12 14 15 16 17 18 19 20 21 22 23 24 25 26 28 30 32 34 36 38 40 40 42 45"
_OUTER_10 = (
    "26 28 32 35 42 47 55 62 68 75 80 90 95 100 110 115 125 130 140 145 150 160 170 180 200 210 225"
)
_WIDTH_10 = "8 8 9 10 12 12 13 14 15 16 16 18 18 18 20 20 22 22 24 24 24 26 28 28 33 33 35"
_OUTER_03 = "35 37 42 47 52 62 72 80 90 100 110 120 130 140 150 160 170 180 190 200 215 225 240 260 280 300 320"
_WIDTH_03 = "11 12 13 14 15 17 19 21 23 25 27 29 31 33 35 37 39 41 43 45 47 49 50 55 58 62 65"
_WIDTH_T = "15 15 17 18 19 20 20 23 23 23 25 25 29 29 32 32 32 35 38 38 45 45 48"

BOUNDARIES = {
    **_boundary("60", _OUTER_10, _WIDTH_10),
    **_boundary("62", _OUTER_02, _WIDTH_02),
    **_boundary("63", _OUTER_03, _WIDTH_03),
    **_boundary("N2", _OUTER_02, _WIDTH_02),
    **_boundary("NU2", _OUTER_02, _WIDTH_02),
    **_boundary("320", " ".join(_OUTER_10.split()[4:]), _WIDTH_T, " ".join(_TENS.split()[4:])),
}

#: Boundary dimensions that others published: bearings of DIN 625-1 in the library BOLTS (https://github.com/boltsparts/BOLTS_archive,
#: data/bearings.blt), tapered ones of the catalogue of Nachi, and those of a gear unit of SEW-Eurodrive in a file of REXS.
PUBLISHED_BOUNDARIES = {
    "6000": [10, 26, 8],
    "6001": [12, 28, 8],
    "6002": [15, 32, 9],
    "6003": [17, 35, 10],
    "6004": [20, 42, 12],
    "6005": [25, 47, 12],
    "6006": [30, 55, 13],
    "6007": [35, 62, 14],
    "6200": [10, 30, 9],
    "6201": [12, 32, 10],
    "6202": [15, 35, 11],
    "6203": [17, 40, 12],
    "6204": [20, 47, 14],
    "6205": [25, 52, 15],
    "6206": [30, 62, 16],
    "6207": [35, 72, 17],
    "6300": [10, 35, 11],
    "6301": [12, 37, 12],
    "6302": [15, 42, 13],
    "6303": [17, 47, 14],
    "6304": [20, 52, 15],
    "6305": [25, 62, 17],
    "6308": [40, 90, 23],
    "32004": [20, 42, 15],
    "32005": [25, 47, 15],
    "32006": [30, 55, 17],
    "32007": [35, 62, 18],
}
#: Outside diameters of the diameter series 2, which the double-row ball bearings 42.. of DIN 625-3 share: library BOLTS.
PUBLISHED_DIAMETERS_2 = dict(
    zip(
        range(19),
        [30, 32, 35, 40, 47, 52, 62, 72, 80, 85, 90, 100, 110, 120, 125, 130, 140, 150, 160],
        strict=True,
    )
)


def rated_hours(load: float, capacity: float, exponent: float, rad_per_second: float) -> float:
    """Give the basic rating life of ISO 281 [h] under a constant load [N] at the speed of the bearing."""
    turns_per_hour = 3600.0 * abs(rad_per_second) / (2.0 * math.pi)
    return RATED_TURNS * (capacity / load) ** exponent / turns_per_hour
