"""Tables of docs/explanation/paper-study.md and results/paper/README.md from the files in results/paper."""
import collections
import csv
import math
import pathlib
import re

KEPT = pathlib.Path(__file__).resolve().parent.parent.parent / "results/paper"
PUBLISHED_TRIALS = 20000
STATISTICS = ("worst", "average", "best")
CONDITIONS = ("1e5", "1e8", "1e10")

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


def sweeps(file):
    """(set, solver, sweep): its row."""
    return {(row["set"], row["solver"], row["sweep"]): row for row in rows_of(file)}


def range_of(row, count):
    return Range(int(row["trials"]), *(float(row[f"{count}.{statistic}"]) for statistic in STATISTICS))


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


def agreement(ours, published):
    return ", ".join(beyond(ours, published)) or "none"


def set_name(kind, experiment, *options):
    given = ",".join(option for option in options if option)
    return f"paper/{kind}/{experiment}" + (f"{{{given}}}" if given else "")


def experiments():
    """(title, name, redundancy) of Experiments 1 to 5 in their readings."""
    for name in ("exp1", "exp2", "exp3", "exp4", *(f"exp5-{condition}" for condition in CONDITIONS)):
        title = name[3:4] + (f" at {name[5:]}" if "-" in name else "")
        if name in ("exp1", "exp3"):
            yield title, name, ""
            continue
        yield f"{title}, `multiple`", name, ""
        yield f"{title}, `combination`", name, "redundancy=combination"


def rules_table(kind, family, solver, sweep, options):
    """The rows of a solver by the rules of 2012. @param options: of each experiment's sets; without: the default"""
    rates, found = published_rates(), sweeps("rules.csv")
    lines = ["| Experiment | published | trials | claimed | any answer | more than 3 standard errors apart |",
             "| --- " * 6 + "|"]
    for title, name, redundancy in experiments():
        for option in options.get(name, [""]):
            row = found.get((set_name(kind, name, redundancy, option), solver, sweep))
            if row is None:
                continue
            published = rates[kind, name, family]
            any_answer = range_of(row, "criterion_any")
            label = title + (", `inverse=plain`" if "inverse" in option else "")
            lines.append(f"| {label} | {shown(published, 2)} | {any_answer.trials} | "
                         f"{shown(range_of(row, 'criterion')[1:])} | {shown(any_answer[1:])} | "
                         f"{agreement(any_answer, published)} |")
    return "\n".join(lines) + "\n"


RULES_OF_LEMKE = "paper{cap=lemke,rules=2012}"
PLAIN_TOO = {"exp3": ["", "inverse=plain"], "exp4": ["", "inverse=plain"]}
DIAL = {name: ["cone_diagonal=1e-16" + (",inverse=plain" if name in PLAIN_TOO else "")]
        for name in ("exp1", "exp2", "exp3", "exp4", *(f"exp5-{condition}" for condition in CONDITIONS))}


def ablation_table():
    """What each rule changes, on a seed to which nothing was fitted."""
    rates, found = published_rates(), sweeps("ablation.csv")
    columns = [("paper{cap=lemke}", "criterion"), ("paper{update=incremental,cap=lemke}", "criterion"),
               (RULES_OF_LEMKE, "criterion"), (RULES_OF_LEMKE, "criterion_any")]
    lines = ["| Experiment | dial | published | standard rules | incremental x | `rules=2012`, claimed | "
             "`rules=2012`, any answer |", "| --- " * 7 + "|"]
    for title, name, redundancy in experiments():
        if redundancy:
            continue
        for dial in ("", "cone_diagonal=1e-16"):
            inverse = "inverse=plain" if name in PLAIN_TOO else ""
            label = title.split(",")[0] + (f", `{inverse}`" if inverse else "")
            where = set_name("copositive", name, dial, inverse)
            shares = [shown(range_of(found[where, "lemke", sweep], count)[1:], 0) for sweep, count in columns]
            lines.append(f"| {'' if dial else label} | {'1e-16' if dial else '-'} | "
                         f"{'' if dial else shown(rates['copositive', name, 'Lemke'], 0)} | {' | '.join(shares)} |")
    return "\n".join(lines) + "\n"


def path_table():
    """PATH 4.7.03, measured apart from the run."""
    with open(KEPT / "path-4.7.03.csv", newline="") as lines:
        cells = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    rates = published_rates()
    lines = ["| Experiment | published | claimed, by the criterion | any answer, by the criterion |", "| --- " * 4 + "|"]
    for title, name, redundancy in experiments():
        if redundancy:
            continue
        of_set = [cell for cell in cells if cell["set"] == set_name("monotone", name)]
        texts = []
        for count in ("claimed_and_criterion", "criterion_any_claim"):
            shares = [int(cell[count]) / int(cell["trials"]) for cell in of_set]
            texts.append(shown((min(shares), sum(shares) / len(shares), max(shares)), 2))
        lines.append(f"| {title.split(',')[0]} | {shown(rates['monotone', name, 'PATH'], 2)} | {' | '.join(texts)} |")
    return "\n".join(lines) + "\n"


def claims_table(old):
    """The result and the counts of each claim, in the order of the kept file; the first and last column stay."""
    claims = collections.OrderedDict()
    for row in rows_of("tables/claims-paper.csv"):
        claims.setdefault(row["claim"], []).append(row)
    rows = [[part.strip() for part in line.strip()[1:-1].split(" | ")] for line in old.splitlines()[2:]]
    if len(rows) != len(claims):
        raise SystemExit(f"the table of claims has {len(rows)} rows; tables/claims-paper.csv has {len(claims)} claims")
    lines = ["| claim | result | for, against, of | which part, and why |", "| --- | --- | --- | --- |"]
    for row, comparisons in zip(rows, claims.values()):
        stances = collections.Counter(each["stance"] for each in comparisons if each["part"] == "claim")
        of = sum(stances[stance] for stance in ("supports", "opposes", "undecided"))
        counts = f"{stances['supports']}, {stances['opposes']}, {of}" if of else "-"
        word = "; ".join([comparisons[0]["word"], *row[1].split("; ")[1:]])
        lines.append(f"| {row[0]} | {word} | {counts} | {row[-1]} |")
    return "\n".join(lines) + "\n"


def shares_table():
    """Every row of lemke{cap=3n}, in Experiment 6 inside regularized{test=tried}, by all three counts."""
    lines = ["| problems | experiment | redundancy | trials | published | paper's criterion | any answer | our verdict |",
             "| --- " * 8 + "|"]
    for table in ("IV.1", "IV.2"):
        for row in rows_of(f"tables/paper-{table}.csv"):
            wrapped = row["experiment"].startswith("exp6")
            if row["solver"] != ("regularized{solver=lemke{cap=3n},test=tried}" if wrapped else "lemke{cap=3n}"):
                continue
            if not row["set"]:
                continue
            published = [row[f"published.{statistic}"] for statistic in STATISTICS]
            ours = [[row[f"{count}.worst.share"], row[f"{count}.average"], row[f"{count}.best.share"]]
                    for count in ("criterion", "criterion_any", "verdict")]
            texts = [" / ".join(points(float(value)) if value else "-" for value in values)
                     for values in (published, *ours)]
            lines.append(f"| {row['kind']} | {row['experiment']} | {row['redundancy']} | "
                         f"{float(row['trials']):.0f} | {' | '.join(texts)} |")
    return "\n".join(lines) + "\n"


def paper_table(name, old):
    makers = {
        "shares": shares_table,
        "claims": lambda: claims_table(old),
        "lemke-frictionless": lambda: rules_table("monotone", "Lemke", "lemke", RULES_OF_LEMKE, PLAIN_TOO),
        "lemke-frictional": lambda: rules_table("copositive", "Lemke", "lemke", RULES_OF_LEMKE, PLAIN_TOO),
        "lemke-dial": lambda: rules_table("copositive", "Lemke", "lemke", RULES_OF_LEMKE, DIAL),
        "interior-point": lambda: rules_table("monotone", "IP", "primal_dual", "paper{rules=2012}", PLAIN_TOO),
        "ablation": ablation_table,
        "path": path_table,
    }
    return makers[name]()
