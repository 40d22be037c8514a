"""Draws the factorization of a matrix: its tree, its fill, and when what was done.

    draw_factorization.py [--points K | --file A.mtx] [--threads T] PICTURE.png

Without a file, the matrix is that of convection and diffusion on a grid of K x K x K points (40). Needs scipy and matplotlib.
"""

import argparse
import time

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import scipy.io
import scipy.sparse as sparse

import mfs


def convection(k):
    """Centred differences; what flows along x, y and z makes it unsymmetric."""
    line = sparse.diags_array([-1.4 * np.ones(k - 1), 2 * np.ones(k), -0.6 * np.ones(k - 1)], offsets=[-1, 0, 1])
    one = sparse.eye_array(k)
    along = sparse.kron(line, one) + sparse.kron(one, line)
    return (sparse.kron(along, one) + sparse.kron(sparse.eye_array(k * k), line)).tocsr()


def read(path):
    """A Matrix Market file. SciPy before 1.15 does not know what later ones want to be told."""
    try:
        return sparse.csr_array(scipy.io.mmread(path, spmatrix=False))
    except TypeError:
        return sparse.csr_array(scipy.io.mmread(path))


def follow(a, threads):
    """The factorization, one solution's backward error, and a list of (seconds, phase, fraction)."""
    seen, begin = [], time.perf_counter()
    lu = mfs.splu(a, threads=threads, progress=lambda phase, part: seen.append((time.perf_counter() - begin, phase, part)))
    lu.solve(a @ np.ones(a.shape[0]))
    return lu, seen


def draw_tree(axes, depths):
    """A row of boxes for each depth, one for each front up to 64; colours are the rows of the largest."""
    colours = plt.get_cmap("viridis_r")
    most = np.log(max(2, depths["max_front"].max()))
    for row in depths:
        boxes = min(row["fronts"], 64)
        for box in range(boxes):
            axes.barh(row["depth"], 0.9 / boxes, 0.8, left=(box + 0.05) / boxes, color=colours(np.log(row["max_front"]) / most))
        axes.text(1.01, row["depth"], f"{row['fronts']} of up to {row['max_front']}", va="center", fontsize=7)
    axes.set(title="Tree: fronts, and rows of the largest", ylabel="depth", xlim=(0, 1.35), xticks=[])
    axes.invert_yaxis()


def draw_fill(axes, depths, nonzeros):
    axes.barh(depths["depth"], depths["factor_entries"] / 1e6, 0.8, label="L and U")
    axes.barh(depths["depth"], depths["contribution_entries"] / 1e6, 0.4, label="contribution blocks")
    axes.axvline(nonzeros / 1e6, color="black", linestyle=":", label="the matrix, all of it")
    axes.set(title="Fill", xlabel="million entries", ylabel="depth")
    axes.invert_yaxis()
    axes.legend(fontsize=8)


def draw_times(axes, seen, depths):
    """How far each phase has come; depths of the tree, the deepest first, lie at their shares of the operations."""
    for phase in dict.fromkeys(name for _, name, _ in seen):
        of_phase = [(second, part) for second, name, part in seen if name == phase]
        axes.plot(*zip(*of_phase), marker=".", label=phase)
    bottom_up = np.cumsum(depths["flops"][::-1]) / max(depths["flops"].sum(), 1)
    for depth, share in zip(depths["depth"][::-1], bottom_up):
        if share > 0.03:
            axes.axhline(share, color="lightgrey", zorder=0)
            axes.text(0, share, f"depth {depth}", va="top", fontsize=7, color="grey")
    axes.set(title="When: lines are depths of the tree", xlabel="s", ylabel="part of the phase that is done")
    axes.legend(fontsize=8, loc="center right")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("picture")
    parser.add_argument("--points", type=int, default=40)
    parser.add_argument("--file")
    parser.add_argument("--threads", type=int, default=0)
    given = parser.parse_args()
    a = read(given.file) if given.file else convection(given.points)
    lu, seen = follow(a, given.threads)
    report = lu.report
    figure, (tree, fill, times) = plt.subplots(1, 3, figsize=(15, 5))
    draw_tree(tree, lu.depths)
    draw_fill(fill, lu.depths, report["nnz"])
    draw_times(times, seen, lu.depths)
    for axes in (tree, fill):
        axes.yaxis.get_major_locator().set_params(integer=True)
    figure.subplots_adjust(left=0.04, right=0.99, bottom=0.12, top=0.84, wspace=0.16)
    figure.suptitle(
        f"{report['n']} unknowns, {report['nnz']} entries; {report['flops']:.1e} operations, "
        f"backward error {report['backward_error']:.0e}"
    )
    figure.savefig(given.picture, dpi=75)
    print(f"{given.picture}: {report['fronts']} fronts, {report['nnz_factor'] / report['nnz']:.1f} times the entries")


if __name__ == "__main__":
    main()
