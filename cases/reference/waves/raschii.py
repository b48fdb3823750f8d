"""Makes raschii.csv: elevation and velocity of regular waves by raschii 2.0.0 (PyPI).

    pip install raschii==2.0.0
    python raschii.py > raschii.csv
"""

import sys

import numpy as np

sys.path.pop(0)  # this script has the package's name
import raschii

GRAVITY = 9.81
WAVES = [
    # model, order, depth, height, wavelength (m)
    ("Stokes", 2, 0.4, 0.06, 1.9362),
    ("Stokes", 2, 0.7, 0.1, 1.5506),
    ("Fenton", 10, 0.4, 0.06, 1.9558),
    ("Fenton", 10, 0.7, 0.1, 1.6094),
    ("Fenton", 12, 0.4, 0.12, 3.5),
    ("Fenton", 16, 10.0, 6.0, 100.0),
    ("Fenton", 8, 200.0, 15.0, 150.0),
]

print(f"# raschii {raschii.__version__}, crest at x = 0, y up from the bed, SI")
print("model,order,depth_m,gravity_m_s2,height_m,wavelength_m,period_s,x_m,y_m,elevation_m,u_m_s,v_m_s")
for model, order, depth, height, length in WAVES:
    Model = raschii.get_wave_model(model, None)[0]
    extra = {"maxiter": 5000} if model == "Fenton" else {}
    wave = Model(height=height, depth=depth, length=length, N=order, g=GRAVITY, **extra)
    for x in np.linspace(0.0, 0.5 * length, 9):
        surface = float(wave.surface_elevation(x))
        for y in (0.0, 0.5 * depth, 0.9 * surface):
            u, v = (float(c) for c in np.ravel(wave.velocity(x, y)))
            row = (depth, GRAVITY, height, length, length / wave.c, x, y, surface - depth, u, v)
            print(f"{model},{order}," + ",".join(f"{value:.12g}" for value in row))
