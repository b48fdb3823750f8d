"""Linear potential flow of sections that float in beam waves, by boundary elements; numpy alone.

    python linear_sections.py

prints the checks against box_linear_potential (README.md of this folder) and the amplitudes that
cases are compared with. x along the waves, y up from the still water, angles counter-clockwise,
exp(-i omega t), per metre of width.
"""

import numpy as np

G, DENSITY = 9.81, 1000.0


def wave_number(omega, depth):
    """g k tanh k D = omega^2, by Newton's method."""
    k = omega**2 / G + 1e-9
    for _ in range(50):
        tanh = np.tanh(k * depth)
        k -= (G * k * tanh - omega**2) / (G * tanh + G * k * depth * (1 - tanh**2))
    return k


def line(p, q, size_p, size_q):
    """Ends of panels from p to q, whose sizes go from size_p to size_q."""
    p, q = np.array(p, float), np.array(q, float)
    length = np.linalg.norm(q - p)
    s = np.linspace(0, length, 2001)
    density = 1 / (size_p + (size_q - size_p) * s / length)
    count = np.concatenate([[0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(s))])
    n = max(2, int(np.ceil(count[-1])))
    at = np.interp(np.linspace(0, count[-1], n + 1), count, s)
    return p + np.outer(at / length, q - p)


def hull(corners, fine):
    """Ends of panels along the corners, small at each of them."""
    points = [np.array(corners[0], float)]
    for a, b in zip(corners[:-1], corners[1:]):
        middle = 0.5 * (np.array(a) + np.array(b))
        half = np.linalg.norm(np.array(b) - np.array(a)) / 2
        coarse = min(6 * fine, max(fine, half / 6))
        points += [*line(a, middle, fine, coarse)[1:], *line(middle, b, coarse, fine)[1:]]
    return np.array(points)


def solve(bodies, depth, omega, fine=0.002):
    """Added mass, damping and exciting loads per metre of the amplitude of a cos(k x - omega t), three
    modes (sway, heave, roll about the centre) for each of `bodies`, from left to right: corners of
    the wetted outline from the left to the right end of its water line, and the centre."""
    k = wave_number(omega, depth)
    far = max(6 * depth, 2 * np.pi / k)
    big = min(2 * np.pi / k / 60, depth / 10)
    left, right = bodies[0][0][0][0] - far, bodies[-1][0][-1][0] + far
    # Counter-clockwise around the water. A lid lets one outgoing wave through.
    pieces = [("bed", line([left, -depth], [right, -depth], big, big))]
    pieces += [("lid", line([right, -depth], [right, 0], big, big / 2))]
    end, size = [right, 0], big / 2
    for number, (corners, _) in reversed(list(enumerate(bodies))):
        pieces += [("surface", line(end, corners[-1], size, fine))]
        pieces += [(number, hull(corners[::-1], fine))]
        end, size = corners[0], fine
    pieces += [("surface", line(end, [left, 0], size, big / 2))]
    pieces += [("lid", line([left, 0], [left, -depth], big / 2, big))]
    ends = np.concatenate([pieces[0][1][:1]] + [points[1:] for _, points in pieces])
    part = np.array(sum(([str(name)] * (len(points) - 1) for name, points in pieces), []))

    # Constant panels: integrals of ln r and of its normal derivative over each, at each middle.
    a, b = ends[:-1], ends[1:]
    middle, length = 0.5 * (a + b), np.linalg.norm(b - a, axis=1)
    along = (b - a) / length[:, None]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1)
    offset = middle[:, None, :] - a[None, :, :]
    x1 = np.einsum("ijk,jk->ij", offset, along)
    y = np.einsum("ijk,jk->ij", offset, normal)
    x2 = x1 - length
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = np.where(np.abs(y) > 1e-14, np.arctan(x1 / y) - np.arctan(x2 / y), 0.0)
        log = [np.where(x**2 + y**2 > 0, 0.5 * x * np.log(x**2 + y**2), 0.0) for x in (x1, x2)]
    single = log[0] - log[1] - length + y * angle
    np.fill_diagonal(angle, 0.0)
    np.fill_diagonal(single, length * (np.log(length / 2) - 1))
    # A constant has no flux.
    double = np.diag(angle.sum(axis=1)) - angle

    impedance = np.zeros(len(part), complex)
    impedance[part == "surface"] = omega**2 / G
    impedance[part == "lid"] = 1j * k
    modes = np.zeros((3 * len(bodies), len(part)))
    for number, (_, centre) in enumerate(bodies):
        own = part == str(number)
        arm = middle[own] - np.array(centre)
        n = normal[own]
        turn = arm[:, 0] * n[:, 1] - arm[:, 1] * n[:, 0]
        modes[3 * number : 3 * number + 3, own] = [n[:, 0], n[:, 1], turn]
    hulls = np.abs(modes).sum(axis=0) > 0
    wave = -1j * G / omega * np.exp(1j * k * middle[:, 0]) / np.cosh(k * depth)
    cosh, sinh = (f(k * (middle[:, 1] + depth)) for f in (np.cosh, np.sinh))
    flux = wave * k * (1j * cosh * normal[:, 0] + sinh * normal[:, 1])
    given = np.column_stack([modes.T, np.where(hulls, -flux, 0)])
    potential = np.linalg.solve(double - single * impedance, single @ given)
    incident = np.where(hulls, wave * cosh, 0)
    loads = 1j * omega * DENSITY * np.einsum("jp,pk,p->jk", modes, potential, length)
    excitation = loads[:, -1] + 1j * omega * DENSITY * modes @ (incident * length)
    return loads[:, :-1].imag / omega, -loads[:, :-1].real, excitation


def area_and_centroid(corners):
    x, y = np.array(corners, float).T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = cross.sum() / 2
    return abs(area), ((y + np.roll(y, -1)) * cross).sum() / (6 * area)


def motions(bodies, masses, inertias, depth, period, stiffness=0.0, damping=0.0):
    """Complex amplitudes per metre of wave amplitude; `stiffness` (N/m^2) acts in sway, `damping`
    (N s/m^2) in sway and heave, at the centre of each body."""
    omega = 2 * np.pi / period
    added, radiated, excitation = solve(bodies, depth, omega)
    inertia, restoring, friction = [], [], []
    for (corners, centre), mass, turning in zip(bodies, masses, inertias):
        area, buoyancy = area_and_centroid(corners)
        beam = corners[-1][0] - corners[0][0]
        weight = DENSITY * G
        inertia += [mass, mass, turning]
        restoring += [stiffness, weight * beam]
        restoring += [weight * (beam**3 / 12 + area * buoyancy) - mass * G * centre[1]]
        friction += [damping, damping, 0.0]
    matrix = np.diag(restoring) - omega**2 * (np.diag(inertia) + added)
    return np.linalg.solve(matrix - 1j * omega * (radiated + np.diag(friction)), excitation)


def box(x):
    return [(x - 0.15, 0), (x - 0.15, -0.1), (x + 0.15, -0.1), (x + 0.15, 0)], (x, 0.0)


def ship(above_keel):
    """The section of Sundsdal et al. (2025), as in cases/ship_section.toml."""
    bilge = [(-0.2, -0.1488), (-0.1983, -0.1621), (-0.1931, -0.1744), (-0.185, -0.185)]
    bilge += [(-0.1744, -0.1931), (-0.1621, -0.1983), (-0.1488, -0.2)]
    corners = [(-0.2, 0), *bilge, *((-x, y) for x, y in reversed(bilge)), (0.2, 0)]
    return corners, (0.0, above_keel - 0.2)


def main():
    added, damping, loads = solve([box(0.0)], 0.4, 2 * np.pi / 1.2)
    found = abs(motions([box(0.0)], [30.0], [0.325], 0.4, 1.2))
    print("box, T = 1.2 s: found; two independent solutions")
    print("  A11, A33, A55 ", np.diag(added).round(4), "; 27.67, 30.95, 0.12505")
    print("  B11, B33      ", np.diag(damping)[:2].round(2), "; 104.8, 167.5")
    print("  motion per m  ", found.round(3), "; 0.921, 1.242, 1.866")
    print("ship section, run 3012, H = 0.0395 m: sway mm, heave mm, roll mrad; measured 18.2, 23.7, 83.4")
    for above_keel in (0.104, 0.105, 0.106, 0.107, 0.108):
        found = motions([ship(above_keel)], [78.83], [1.6346], 1.0, 1.516, 101.4, 14.84)
        print(f"  centre {above_keel} m above the keel", (1e3 * 0.01975 * abs(found)).round(1))
    print("two boxes, gap 0.2 m, T = 1.2 s, per metre of amplitude: sway, heave, roll of either")
    boxes = [box(-0.25), box(0.25)]
    found = motions(boxes, [30.0] * 2, [0.325] * 2, 0.4, 1.2)
    print("  weather", abs(found[:3]).round(3), " lee", abs(found[3:]).round(3))


if __name__ == "__main__":
    main()
