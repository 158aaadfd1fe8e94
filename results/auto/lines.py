"""Of costs.csv: on how many of the islands that a method solves its first turn in native/auto/order.cpp is enough."""
import csv
import math
import pathlib
import re

FOLDER = pathlib.Path(__file__).parent
ENUM = {"kContactLemke": "contact_lemke", "kContactIpm": "contact_ipm", "kFrictionIpm": "friction_ipm", "kPsor": "psor",
        "kActiveSet": "active_set", "kVelocityIpm": "velocity_ipm"}


def main():
    code = (FOLDER / "../../native/auto/order.cpp").read_text(encoding="utf-8")
    lines = re.findall(r"(k\w+)\{AutoMethod::(k\w+), (0x[\d.p]+), (\d+)", code)
    least = 2.0**17  # Order::kLeastWork
    with open(FOLDER / "costs.csv", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["work_1e-6"]]
    print("| line | work | islands | enough on |\n| --- | --- | --- | --- |")
    for name, method, factor, quarters in lines:
        friction = "0" if name in ("kActiveSet", "kVelocityIpm") or name.startswith("kFrictionless") else "1"
        own = [row for row in rows if row["method"] == ENUM[method] and row["friction"] == friction]

        def budget(row):
            n = math.sqrt(float(row["contacts"]) * float(row["coordinates"]))
            return max(float.fromhex(factor) * n ** (int(quarters) / 4), least)

        share = sum(float(row["work_1e-6"]) <= budget(row) for row in own) / len(own)
        print(f"| {name[1:]} | {float.fromhex(factor):g} n^{int(quarters) / 4:g} | {len(own)} | {100 * share:.0f} % |")


if __name__ == "__main__":
    main()
