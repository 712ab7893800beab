"""The measurements as a table in Markdown."""


def table(results):
    """All of `results` (bench.py) as text."""
    lines = [
        "## Fluid alone",
        "",
        "| domain | precision | collision | ranks | memory copy GB/s | 19 streams M cells/s | fluid MLUPS | share |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in results["pure"]:
        lines.append(
            f"| {_cells(row['domain_cells'])} | {row['precision']} | {row['collision']} | {row['ranks']} "
            f"| {row['median_copy_gb_per_s']:.1f} | {row['median_streams_mcells_per_s']:.1f} "
            f"| {row['median_fluid_mlups']:.1f} | {row['median_share_of_limit']:.2f} |"
        )
    lines += [
        "",
        "## Coupled, double precision, three services over ipc",
        "",
        "| domain | symmetry planes | beads | ranks | coupled MLUPS | fluid alone MLUPS | ratio | coupling overhead |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in results["coupled"]:
        planes = ", ".join(row["symmetry_planes"]) or "none"
        lines.append(
            f"| {_cells(row['domain_cells'])} | {planes} | {row['beads']} | {row['ranks']} "
            f"| {row['median_coupled_mlups']:.1f} | {row['median_fluid_mlups']:.1f} "
            f"| {row['median_ratio']:.3f} | {row['median_coupling_overhead']:.3f} |"
        )
    lines += ["", "## Phases of a coupled step, rank 0, percent of the fluid's time", ""]
    lines += _phase_table(results["coupled"])
    return "\n".join(lines)


def _phase_table(rows):
    phases = list(rows[0]["samples"][0]["phases_s"]["fluid"]) if rows else []
    lines = ["| domain | beads | " + " | ".join(phases) + " |", "|---|---|" + "---|" * len(phases)]
    for row in rows:
        seconds = row["samples"][-1]["phases_s"]["fluid"]
        total = sum(seconds.values()) or 1.0
        shares = " | ".join(f"{100 * seconds[phase] / total:.1f}" for phase in phases)
        lines.append(f"| {_cells(row['domain_cells'])} | {row['beads']} | {shares} |")
    return lines


def _cells(domain):
    return "×".join(map(str, domain))
