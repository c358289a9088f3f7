"""What every figure is made of: quantiles, rounds, the table and the JSON file."""

import json
import platform
import statistics


def quantile(values, share):
    """The value that `share` (0..1) of `values` does not exceed."""
    ordered = sorted(values)
    if not ordered:
        raise ValueError("no values were measured")
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)]


class Figures:
    """Rows of the table: a quantity, ours, its yardstick's value, their ratio, and the target."""

    def __init__(self):
        self.rows = []

    def ratio(self, name, quantity, unit, pairs, target):
        """`pairs`: (ours, yardstick) of each round, measured side by side; the figure is the median of the ratios. `target` None: it stands
        beside the others, unjudged."""
        ratios = [ours / other if other else float("inf") for ours, other in pairs]
        self.rows.append(
            {
                "figure": name,
                "quantity": quantity,
                "unit": unit,
                "ours": statistics.median(ours for ours, _ in pairs),
                "yardstick": statistics.median(other for _, other in pairs),
                "ratio": statistics.median(ratios),
                "ratio_lowest": min(ratios),
                "ratio_highest": max(ratios),
                "target": target,
                "met": None if target is None else statistics.median(ratios) <= target,
                "rounds": len(pairs),
            }
        )

    def limit(self, name, quantity, unit, values, target, yardstick=None):
        """A figure with a bound of its own; the worst round counts."""
        self.rows.append(
            {
                "figure": name,
                "quantity": quantity,
                "unit": unit,
                "ours": max(values),
                "yardstick": yardstick,
                "ratio": None,
                "target": target,
                "met": max(values) <= target,
                "rounds": len(values),
            }
        )

    def print(self):
        heads = ("", "quantity", "ours", "yardstick", "ratio (lowest..highest)", "target", "")
        lines = [heads] + [self._cells(row) for row in self.rows]
        widths = [max(len(line[i]) for line in lines) for i in range(len(heads))]
        for line in lines:
            print("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip())

    @staticmethod
    def _cells(row):
        def number(value):
            return "-" if value is None else f"{value:.4g} {row['unit']}".strip()

        ratio = "-"
        if row["ratio"] is not None:
            ratio = f"{row['ratio']:.2f} ({row['ratio_lowest']:.2f}..{row['ratio_highest']:.2f})"
        target = "-" if row["target"] is None else f"<= {row['target']:.4g}"
        if row["ratio"] is None:
            target = f"{target} {row['unit']}".strip()
        met = {None: "", True: "met", False: "MISSED"}[row["met"]]
        return (row["figure"], row["quantity"], number(row["ours"]), number(row["yardstick"]), ratio, target, met)

    def write(self, path):
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
        machine = {"processors": len(names), "model": names[0] if names else "", "kernel": platform.release()}
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"machine": machine, "figures": self.rows}, file, indent=1)
            file.write("\n")
