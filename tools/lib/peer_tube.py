"""The tube's modes by other programs on the mesh that klang solves: CalculiX and SciPy. Quadratic tetrahedra, straight edges."""
import json
import os
import pathlib
import re
import subprocess
import sys
import time

import numpy as np

EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))  # CalculiX' C3D10 order of middles


def read_msh(path):
    """Nodes and linear tetrahedra of a Gmsh 4.1 text file."""
    lines = iter(pathlib.Path(path).read_text().split("\n"))
    nodes, tets = {}, []
    for line in lines:
        if line == "$Nodes":
            for _ in range(int(next(lines).split()[0])):
                count = int(next(lines).split()[3])
                tags = [int(next(lines)) for _ in range(count)]
                for tag in tags:
                    nodes[tag] = [float(x) for x in next(lines).split()[:3]]
        elif line == "$Elements":
            for _ in range(int(next(lines).split()[0])):
                _, _, kind, count = (int(x) for x in next(lines).split())
                for _ in range(count):
                    row = [int(x) for x in next(lines).split()]
                    if kind == 4:
                        tets.append(row[1:])
    index = {tag: i for i, tag in enumerate(nodes)}
    return np.array(list(nodes.values())), np.array([[index[t] for t in tet] for tet in tets])


def quadratic(points, tets):
    """Nodes with the middles of all edges, and ten per element."""
    middle, all_points, tens = {}, [p for p in points], []
    for tet in tets:
        ten = list(tet)
        for a, b in EDGES:
            key = (min(tet[a], tet[b]), max(tet[a], tet[b]))
            if key not in middle:
                middle[key] = len(all_points)
                all_points.append(0.5 * (points[key[0]] + points[key[1]]))
            ten.append(middle[key])
        tens.append(ten)
    return np.array(all_points), np.array(tens)


def rule():
    """Points (barycentric) and weights of a product rule on the tetrahedron, exact to degree 5."""
    x, w = np.polynomial.legendre.leggauss(4)
    x, w = 0.5 * (x + 1), 0.5 * w
    points, weights = [], []
    for i, u in enumerate(x):
        for j, v in enumerate(x):
            for k, t in enumerate(x):
                a, b, c = u, v * (1 - u), t * (1 - u) * (1 - v)
                points.append((1 - a - b - c, a, b, c))
                weights.append(w[i] * w[j] * w[k] * (1 - u) ** 2 * (1 - v))
    return np.array(points), np.array(weights)  # sum = 1/6


def assembled(points, tens, young, nu, density, mass_rule):
    """Stiffness and mass, sparse."""
    import scipy.sparse as sparse
    corner = points[tens[:, :4]]
    jacobian = np.stack([corner[:, i] - corner[:, 0] for i in (1, 2, 3)], axis=1)
    volume6 = np.linalg.det(jacobian)
    slopes = np.zeros((len(tens), 4, 3))
    slopes[:, 1:] = np.transpose(np.linalg.inv(jacobian), (0, 2, 1))
    slopes[:, 0] = -slopes[:, 1:].sum(axis=1)
    lam, mu = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
    k = np.zeros((len(tens), 10, 3, 10, 3))
    m = np.zeros((10, 10))
    for l, w in zip(*mass_rule):
        n = np.array([*(l * (2 * l - 1)), *(4 * l[a] * l[b] for a, b in EDGES)])
        m += w * np.outer(n, n)
    for l, w in zip(*four_points()):  # exact for the stiffness: slopes are linear
        g = np.zeros((len(tens), 10, 3))
        for a in range(4):
            g[:, a] = (4 * l[a] - 1) * slopes[:, a]
        for e, (a, b) in enumerate(EDGES):
            g[:, 4 + e] = 4 * (l[a] * slopes[:, b] + l[b] * slopes[:, a])
        factor = w * volume6
        outer = np.einsum("e,eai,ebj->eaibj", factor, g, g)
        k += lam * outer + mu * np.transpose(outer, (0, 1, 4, 3, 2))
        trace = mu * np.einsum("eaibi->eab", outer)
        for i in range(3):
            k[:, :, i, :, i] += trace
    dofs = (3 * tens[:, :, None] + np.arange(3)).reshape(len(tens), 30)
    rows, columns = np.repeat(dofs, 30, axis=1).ravel(), np.tile(dofs, (1, 30)).ravel()
    shape = (3 * len(points), 3 * len(points))
    masses = density * volume6[:, None, None] * np.kron(m, np.eye(3))[None]
    return (sparse.csc_matrix((k.reshape(-1), (rows, columns)), shape=shape),
            sparse.csc_matrix((masses.reshape(-1), (rows, columns)), shape=shape))


def write_inp(path, points, tens, young, nu, density, count):
    with open(path, "w") as f:
        f.write("*NODE, NSET=ALL\n")
        f.writelines(f"{i + 1},{p[0]:.12e},{p[1]:.12e},{p[2]:.12e}\n" for i, p in enumerate(points))
        f.write("*ELEMENT, TYPE=C3D10, ELSET=BODY\n")
        order = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]
        f.writelines(f"{e + 1}," + ",".join(str(t[i] + 1) for i in order) + "\n" for e, t in enumerate(tens))
        f.write(f"*MATERIAL, NAME=M\n*ELASTIC\n{young:.12e},{nu:.12e}\n*DENSITY\n{density:.12e}\n")
        f.write(f"*SOLID SECTION, ELSET=BODY, MATERIAL=M\n*STEP\n*FREQUENCY\n{count}\n*END STEP\n")


def calculix(folder, threads):
    """Wall seconds of the program on job.inp, and the frequencies that it prints."""
    start = time.monotonic()
    run = subprocess.run(["ccx", "job"], cwd=folder, capture_output=True, text=True,
                         env={"PATH": "/usr/bin:/bin", "OMP_NUM_THREADS": str(threads)})
    seconds = time.monotonic() - start
    dat = pathlib.Path(folder, "job.dat")
    if run.returncode != 0 or not dat.exists():
        raise RuntimeError(f"ccx ended with {run.returncode}: {run.stdout[-300:]}")
    found, in_table = [], False
    for line in dat.read_text().split("\n"):
        if "E I G E N V A L U E   O U T P U T" in line:
            in_table = True
        elif "P A R T I C I P A T I O N" in line:
            break
        elif in_table and re.match(r"\s*\d+\s", line):
            # the eigenvalue: seven digits, where the frequency in Hz has seven of another size
            found.append(max(0.0, float(line.split()[1])) ** 0.5 / (2 * np.pi))
    return seconds, found


def four_points():
    """CalculiX' rule for these elements, for the mass too: exact to degree 2, where the mass has degree 4."""
    l = np.full((4, 4), 0.1381966011250105)
    np.fill_diagonal(l, 0.5854101966249685)
    return l, np.full(4, 1 / 24)


def solved_by_scipy(points, tens, young, nu, density, count, mass_rule):
    import scipy
    import scipy.sparse.linalg as linalg
    k, m = assembled(points, tens, young, nu, density, mass_rule)
    start = time.monotonic()  # the eigenproblem alone: reading and assembly are not SciPy's
    shift = -(2 * np.pi * 100.0) ** 2
    values = linalg.eigsh(k, count + 6, m, sigma=shift, return_eigenvectors=True, tol=1e-10)[0]
    seconds = time.monotonic() - start
    return {"seconds": seconds, "version": scipy.__version__,
            "frequency_hz": sorted(np.sqrt(np.maximum(values, 0)) / (2 * np.pi))[6:]}


def main():
    """peer_tube.py prepare|calculix|scipy FOLDER YOUNG NU DENSITY COUNT [four-point-mass]: JSON on standard output."""
    what, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    young, nu, density, count = float(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5]), int(sys.argv[6])
    if what == "calculix":
        seconds, found = calculix(folder, os.cpu_count())
        print(json.dumps({"seconds": seconds, "frequency_hz": found[6:]}))
        return
    points, tens = quadratic(*read_msh(folder / "tube.msh"))
    if what == "prepare":
        write_inp(folder / "job.inp", points, tens, young, nu, density, count + 6)
        print(json.dumps({"nodes": len(points), "elements": len(tens)}))
        return
    mass_rule = four_points() if "four-point-mass" in sys.argv else rule()
    print(json.dumps(solved_by_scipy(points, tens, young, nu, density, count, mass_rule)))


if __name__ == "__main__":
    main()
