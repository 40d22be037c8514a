"""The pictures of perf/study, and what its tables and they have in common."""
import sys

UNDIVIDED = 65536  # wider than any pivot block of these studies


def fail(text):
    sys.exit(f"study: {text}")


def seconds_of(line):
    """Of a factorization once memory is there, if one was timed."""
    return line.get("time_refactor") or line.get("time_factor", 0)


def label(line):
    return (f"{line['backend']}, {line['block']}" if line["tried"] == "block" else
            line["solver"] if line["tried"] == "peer" else f"{line['backend']}, {line['tried']}")


def share_below(products, size):
    total = sum(flops for _, flops in products)
    return sum(flops for low, flops in products if low < size) / total if total > 0 else 0


LANES = {"kernel": "kernels", "out": "to the host", "in": "to the device", "copy": "on the device"}


def spans(activities, kind):
    """[[begin, end], ...] in which something of that kind is at work, ascending and apart."""
    joined = []
    for begin, end in sorted(entry[1:3] for entry in activities if entry[0] == kind):
        if joined and begin <= joined[-1][1]:
            joined[-1][1] = max(joined[-1][1], end)
        else:
            joined.append([begin, end])
    return joined


# Pictures: each gets the axes of one case after the other.


def grouped(lines):
    groups = {}
    for line in lines:
        if line.get("status", "solved") == "solved":
            groups.setdefault(line["case"], []).append(line)
    return groups


def flops_picture(pyplot, lines):
    lines = [line for line in lines if line["block"] == UNDIVIDED]
    figure, axes = pyplot.subplots(figsize=(max(4.5, 1.3 * len(lines) + 1.5), 3.6), constrained_layout=True)
    base = [0.0] * len(lines)
    for kind in ("gemm", "trsm", "getrf"):
        share = [100 * line[f"flops_{kind}"] / max(1, sum(line[f"flops_{k}"] for k in ("getrf", "trsm", "gemm")))
                 for line in lines]
        axes.bar(range(len(lines)), share, bottom=base, label=kind)
        base = [low + high for low, high in zip(base, share)]
    axes.set_xticks(range(len(lines)), [line["case"] for line in lines], rotation=20)
    axes.set(ylabel="% of the operations", title="Operations by kind, blocks undivided")
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return figure


def blocks_picture(pyplot, lines):
    cases = grouped(lines)
    if not cases:
        fail("no case was solved: nothing to draw")
    figure, places = pyplot.subplots(2, len(cases), figsize=(4.2 * len(cases), 6), squeeze=False, sharex="col",
                                     constrained_layout=True)
    others = list(dict.fromkeys(label(row) for rows in cases.values() for row in rows if row["tried"] != "block"))
    for column, (case, rows) in enumerate(cases.items()):
        time, share = places[:, column]
        for backend in dict.fromkeys(row["backend"] for row in rows if row["tried"] == "block"):
            own = [row for row in rows if row["backend"] == backend and row["tried"] == "block"]
            sizes = [row["block"] for row in own]
            time.plot(sizes, [seconds_of(row) for row in own], "o-", label=f"mfs, {backend}")
            share.plot(sizes, [100 * row["flops_gemm"] / row["flops"] for row in own], "o-")
        for row in rows:
            if row["tried"] != "block":
                time.axhline(seconds_of(row), color=f"C{others.index(label(row)) + 3}", linestyle="--", label=label(row))
        time.set(title=case, ylabel="refactor, s", xscale="log")
        time.set_ylim(bottom=0)
        share.set(xlabel="largest block", ylabel="% of the operations in products", ylim=(0, 100))
        time.legend(fontsize=8)
        ticks = sorted({row["block"] for row in rows if row["tried"] == "block"})
        if ticks:
            share.set_xticks(ticks, ticks, fontsize=8, rotation=30)
            share.minorticks_off()
    return figure


def backends_picture(pyplot, lines):
    cases = grouped(lines)
    if not cases:
        fail("no case was solved: nothing to draw")
    backends = list(dict.fromkeys(line["backend"] for rows in cases.values() for line in rows))
    figure, places = pyplot.subplots(1, 2, figsize=(max(7, 2 * len(cases) + 4), 3.6), constrained_layout=True)
    width = 0.8 / len(backends)
    for number, backend in enumerate(backends):
        at, rate, solve = [], [], []
        for place, rows in enumerate(cases.values()):
            for row in rows:
                if row["backend"] == backend:
                    at.append(place + (number - (len(backends) - 1) / 2) * width)
                    rate.append(row["flops"] / max(seconds_of(row), 1e-9) / 1e9)
                    solve.append(row["time_solve"] * 1e3)
        places[0].bar(at, rate, width, label=backend)
        places[1].bar(at, solve, width, label=backend)
    for axes, what in zip(places, ("refactor, Gflop/s", "solve of one right-hand side, ms")):
        axes.set_xticks(range(len(cases)), list(cases), rotation=20)
        axes.set(ylabel=what, yscale="log")
    places[0].legend()
    return figure


def timeline_picture(pyplot, lines):
    figure, places = pyplot.subplots(len(lines), 2, figsize=(11, 1.3 * len(lines) + 1), squeeze=False, constrained_layout=True)
    for line, axes in zip(lines, places):
        for phase, place in zip(("refactor", "solve"), axes):
            kinds = [kind for kind in LANES if spans(line[phase]["activities"], kind)]
            for lane, kind in enumerate(kinds):
                ranges = [(1e3 * begin, 1e3 * (end - begin)) for begin, end in spans(line[phase]["activities"], kind)]
                place.broken_barh(ranges, (lane - 0.4, 0.8), color=f"C{list(LANES).index(kind)}")
            place.set_yticks(range(len(kinds)), [LANES[kind] for kind in kinds], fontsize=8)
            place.set(xlim=(0, 1e3 * line[phase]["seconds"]), ylim=(len(kinds) - 0.5, -0.5))
            place.set_title(f"{line['case']}, {line['tried']}: {phase}", fontsize=9)
    for place in places[-1]:
        place.set_xlabel("ms")
    return figure


def sizes_picture(pyplot, lines):
    figure, share = pyplot.subplots(figsize=(7.5, 4), constrained_layout=True)
    for line in lines:
        if "rates" not in line:
            sizes = [size for size, _ in line["products"]]
            sizes += [size * 2**0.5 for size in sizes[-1:]]  # where the last of them ends
            share.plot(sizes, [100 * share_below(line["products"], size) for size in sizes],
                       label=f"{line['case']}, block {line['block']}")
    share.set(xlabel="equivalent square size of a product or front", xscale="log", xlim=(4, 4096), ylim=(0, 100),
              ylabel="% of the operations in smaller products")
    rate = share.twinx()
    for number, line in enumerate(line["rates"] for line in lines if "rates" in line):
        rate.plot([front["size"] for front in line["fronts"]],
                  [front["flops_per_second"] / 1e9 for front in line["fronts"]], "ko" + ("-", "--", ":", "-.")[number % 4],
                  markersize=3, label=f"rate: {line['backend']}, threads: {line['threads']}")
    rate.set(ylabel="rate of fronts of that size, Gflop/s", yscale="log")
    handles = [axes.get_legend_handles_labels() for axes in (share, rate)]
    share.legend(handles[0][0] + handles[1][0], handles[0][1] + handles[1][1], fontsize=8, loc="upper left")
    return figure


def draw(picture, lines, path):
    try:
        import matplotlib
    except ImportError:
        fail("--png needs matplotlib (Debian: python3-matplotlib)")
    matplotlib.use("Agg")
    from matplotlib import pyplot
    picture(pyplot, lines).savefig(path, dpi=90)
