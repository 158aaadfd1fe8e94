"""Tables of docs/explanation/paper-study.md and results/paper/README.md from the files in results/paper."""
import collections
import csv
import math
import pathlib

KEPT = pathlib.Path(__file__).resolve().parent.parent.parent / "results/paper"
PUBLISHED_TRIALS = 20000
STATISTICS = ("worst", "average", "best")

Range = collections.namedtuple("Range", ("trials", *STATISTICS))


def rows_of(file):
    with open(KEPT / file, newline="") as lines:
        return list(csv.DictReader(lines))


def points(share):
    return f"{100 * share:.2f}".rstrip("0").rstrip(".")


def shown(values, digits=1):
    """Worst / average / best in percent."""
    texts = ["-" if value is None else f"{100 * value:.{digits}f}" for value in values]
    texts = [text.rstrip("0").rstrip(".") if "." in text else text for text in texts]
    return f"{texts[0]} flat" if len(set(texts)) == 1 and texts[0] != "-" else " / ".join(texts)


def published_rates():
    """(kind, experiment, the paper's solver): worst, average, best; None where the paper has no number."""
    rates = {}
    with open(KEPT.parent.parent / "study/paper/published.csv", newline="") as lines:
        for row in csv.DictReader(lines):
            if row["quantity"] == "rate":
                values = [float(row[name]) if row[name] else None for name in STATISTICS]
                rates[row["kind"], row["experiment"], row["solver"]] = values
    return rates


def deviations(ours, published):
    """Standard errors between two shares, both of samples."""
    pooled = (ours.share * ours.trials + published * PUBLISHED_TRIALS) / (ours.trials + PUBLISHED_TRIALS)
    error = math.sqrt(pooled * (1 - pooled) * (1 / ours.trials + 1 / PUBLISHED_TRIALS))
    return abs(ours.share - published) / error if error > 0 else 0


def beyond(ours, published):
    """The statistics that lie more than three standard errors apart, of a share of that many trials."""
    share = collections.namedtuple("share", ("share", "trials"))
    return [statistic for statistic, value in zip(STATISTICS, published) if value is not None
            and deviations(share(getattr(ours, statistic), ours.trials), value) > 3]


def set_name(kind, experiment, *options):
    given = ",".join(option for option in options if option)
    return f"paper/{kind}/{experiment}" + (f"{{{given}}}" if given else "")


def path_shares(experiment):
    """PATH 4.7.03, measured apart from the run: of claimed answers, of any answer."""
    with open(KEPT / "path-4.7.03.csv", newline="") as lines:
        cells = [cell for cell in csv.DictReader(line for line in lines if not line.startswith("#"))
                 if cell["set"] == set_name("monotone", experiment)]
    texts = []
    for count in ("claimed_and_criterion", "criterion_any_claim"):
        shares = [int(cell[count]) / int(cell["trials"]) for cell in cells]
        texts.append(shown((min(shares), sum(shares) / len(shares), max(shares)), 2))
    return texts


def claims_table(old):
    """The result and the counts of each claim, in the order of the kept file; the first and last column stay."""
    claims = rows_of("claims.csv")
    rows = [[part.strip() for part in line.strip()[1:-1].split(" | ")] for line in old.splitlines()[2:]]
    if len(rows) != len(claims):
        raise SystemExit(f"the table of claims has {len(rows)} rows; claims.csv has {len(claims)} claims")
    lines = ["| claim | result | for, against, of | which part, and why |", "| --- | --- | --- | --- |"]
    for row, claim in zip(rows, claims):
        stances = [int(claim[stance]) for stance in ("supports", "opposes", "undecided")]
        counts = f"{stances[0]}, {stances[1]}, {sum(stances)}" if sum(stances) else "-"
        word = "; ".join([claim["word"], *row[1].split("; ")[1:]])
        lines.append(f"| {row[0]} | {word} | {counts} | {row[-1]} |")
    return "\n".join(lines) + "\n"


PARAMETERISATIONS = {"Lemke": 81, "IP": 9}
OURS = {"Lemke": ("lemke{cap=3n}", "regularized{solver=lemke{cap=3n},test=tried}"), "IP": ("primal_dual", "regularized{solver=primal_dual}")}
READINGS = {"–": "", "multiple": "m", "combination": "c"}


def share_cell(row, published):
    """Worst / average / best in percent, worst and best with their 95 % intervals; bold where it is far from the published."""
    ours = Range(int(row["trials"]), *(float(row[f"criterion.{name}"]) for name in ("worst.share", "average", "best.share")))
    far, texts = beyond(ours, published), []
    for statistic in STATISTICS:
        text = points(getattr(ours, statistic))
        text = f"**{text}**" if statistic in far else text
        if statistic != "average":
            low, high = (100 * float(row[f"criterion.{statistic}.{end}"]) for end in ("low", "high"))
            text += f" ({low:.1f}-{high:.1f})"
        texts.append(text)
    return " / ".join(texts)


def rates_table(kind):
    """Table IV.1 or IV.2: a row for each experiment and reading of redundancy."""
    rates, rows = published_rates(), {}
    for row in rows_of("rates.csv"):
        if row["kind"] == kind:
            rows.setdefault((row["experiment"], row["redundancy"]), {})[row["solver"]] = row
    titles = ["experiment", "trials", "Lemke, published", "Lemke, ours", "PATH, published"]
    if kind == "monotone":
        titles += ["PATH, claimed", "PATH, any answer", "IP, published", "IP, ours"]
    lines = ["| " + " | ".join(titles) + " |", "| --- " * len(titles) + "|"]
    for (experiment, reading), found in rows.items():
        def both(solver):
            published = rates.get((kind, experiment, solver), [None] * 3)
            row = next((found[name] for name in OURS[solver] if name in found), None)
            return [shown(published, 2), share_cell(row, published) if row else "-"]
        trials = max(int(row["trials"]) for row in found.values())
        cells = [f"{experiment} {READINGS[reading]}".strip(), f"{trials:,}", *both("Lemke"),
                 shown(rates.get((kind, experiment, "PATH"), [None] * 3), 2)]
        if kind == "monotone":
            of_path = reading != "combination" and experiment != "extra100"
            cells += [*(path_shares(experiment) if of_path else ("-", "-")), *both("IP")]
        lines.append("| " + " | ".join("-" if cell == "- / - / -" else cell for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def number(text):
    return f"{float(text):.3g}"


def measurements_table(table):
    """Tables IV.3 to IV.6: mean (standard deviation), largest; a row for each solver, experiment and quantity. The 95 %
    interval of our mean takes the parameterisations, which met the same problems, for one."""
    published = {}
    with open(KEPT.parent.parent / "study/paper/published.csv", newline="") as lines:
        for row in csv.DictReader(lines):
            if row["table"] == table:
                published[row["solver"], row["experiment"], row["quantity"]] = row
    names = {"time_of_solved_s": "time_solved", "time_of_all_s": "time_all", "violation_of_solved_m_per_s": "violation"}
    ours = {(row["solver"], row["experiment"], names[row["quantity"]], row["redundancy"]): row for row in rows_of("measurements.csv")
            if row["table"] == table and row["solved_by"] == "criterion"}
    lines = ["| solver | experiment | best, published | best, ours | n | all, published | all, ours | n |", "| --- " * 8 + "|"]
    for (solver, experiment, quantity), row in published.items():
        name = OURS[solver][1] if solver in OURS else ""
        found = ours.get((name, experiment, quantity, "multiple"))
        what = ", all problems" if quantity == "time_all" else ""
        cells = [solver + what, experiment]
        for of in ("best", "all"):
            cells.append(f"{number(row[of + '_mean'])} ({number(row[of + '_sigma'])}), {number(row[of + '_max'])}" if row[of + "_mean"] else "-")
            if not found:
                cells += ["-", "-"]
                continue
            count = int(float(found[of + ".count"]))
            problems = count / (PARAMETERISATIONS[solver] if of == "all" else 1)
            half = f"{1.96 * float(found[of + '.sigma']) / math.sqrt(problems):.1g}"
            cells += [f"{number(found[of + '.mean'])} ± {half} ({number(found[of + '.sigma'])}), {number(found[of + '.max'])}",
                      f"{count:,}"]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def paper_table(name, old):
    makers = {
        "IV1": lambda: rates_table("monotone"),
        "IV2": lambda: rates_table("copositive"),
        "IV3": lambda: measurements_table("IV.3"),
        "IV4": lambda: measurements_table("IV.4"),
        "IV5": lambda: measurements_table("IV.5"),
        "IV6": lambda: measurements_table("IV.6"),
        "claims": lambda: claims_table(old),
    }
    return makers[name]()
