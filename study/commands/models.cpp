#include <algorithm>

#include "study/commands/commands.h"
#include "study/commands/problem_files.h"
#include "study/evaluation/fastest_contact.h"
#include "study/models/ladder.h"
#include "study/output/columns.h"

namespace lcpbench {
namespace {

struct ModelsArguments {
  std::vector<std::string> files;
  double time_limit_s = 10.0;
  double error = 1e-3;
  bool json = false;
  bool all = false;  ///< every island
};

/// One model on all islands.
struct ModelRow {
  ContactModel model = ContactModel::kNormals;
  std::vector<ModelAnswer> islands;
  std::vector<double> differences;  ///< of each island to the cone's velocity
};

/// The claim of the first island that has no answer; solved where all have.
Claim claim_of(const ModelRow& row) {
  for (const ModelAnswer& island : row.islands) {
    if (!island.answered() || island.claim != Claim::kSolved) return island.claim;
  }
  return Claim::kSolved;
}

std::vector<ModelRow> ladder_of(const std::vector<LadderIsland>& islands, double error,
                               const volatile std::sig_atomic_t* stop) {
  std::vector<ModelRow> rows;
  for (const ContactModel model : kContactModels) {
    if (*stop != 0) return rows;
    ModelRow row{model, {}, {}};
    const double until = model == ContactModel::kConeRough || model == ContactModel::kSoft ? error : kFinestTurn;
    for (const LadderIsland& island : islands) {
      if (*stop != 0) return rows;
      row.islands.push_back(island.ladder->climb(model, until));
    }
    rows.push_back(std::move(row));
  }
  const std::vector<ModelAnswer>& cone = rows.back().islands;
  for (ModelRow& row : rows) {
    for (std::size_t i = 0; i < islands.size(); ++i) {
      const bool known = row.islands[i].answered() && cone[i].answered() && cone[i].claim == Claim::kSolved;
      row.differences.push_back(
          known ? fastest_contact(islands[i].ladder->contacts(), row.islands[i].velocity - cone[i].velocity).m_per_s
                : ModelAnswer::kNone);
    }
  }
  return rows;
}

Json model_json(const ModelAnswer& answer, double difference) {
  return {{"claim", to_string(answer.claim)},
          {"error_m_per_s", json_number(answer.error_m_per_s)},
          {"solver_error_m_per_s", json_number(answer.solver_error_m_per_s)},
          {"velocity_difference_m_per_s", json_number(difference)},
          {"time_s", json_number(answer.time_s)},
          {"passes", answer.passes}};
}

Json ladder_json(const Json& problem, const std::vector<LadderIsland>& islands, const std::vector<ModelRow>& rows) {
  Json json{{"problem", problem}, {"islands", Json::array()}, {"models", Json::array()}};
  for (const LadderIsland& island : islands) {
    json["islands"].push_back({{"contacts", island.contacts}, {"coordinates", island.coordinates.size()}});
  }
  for (const ModelRow& row : rows) {
    double error = 0, solver_error = 0, difference = 0, time_s = 0;
    int passes = 0;
    Json each = Json::array();
    for (std::size_t i = 0; i < row.islands.size(); ++i) {
      const ModelAnswer& island = row.islands[i];
      error = larger_or_nan(error, island.error_m_per_s);
      solver_error = larger_or_nan(solver_error, island.solver_error_m_per_s);
      difference = larger_or_nan(difference, row.differences[i]);
      time_s += island.time_s;
      passes = std::max(passes, island.passes);
      each.push_back(model_json(island, row.differences[i]));
    }
    Json model{{"model", to_string(row.model)},
               {"claim", to_string(claim_of(row))},
               {"error_m_per_s", json_number(error)},
               {"solver_error_m_per_s", json_number(solver_error)},
               {"velocity_difference_m_per_s", json_number(difference)},
               {"time_s", json_number(time_s)},
               {"passes", passes},
               {"islands", std::move(each)}};
    json["models"].push_back(std::move(model));
  }
  return json;
}

/// @param ladder  a problem of the document
void print_ladder(const Json& ladder, bool every_island) {
  constexpr std::size_t kIslandsShown = 8;
  using Align = TextTable::Align;
  const Json& models = ladder["models"];
  const std::vector<JsonColumn> columns{
      {{"model", Align::kLeft}, field("model")},
      {{"claim", Align::kLeft, 3}, field("claim")},
      {{"error m/s"}, field("error_m_per_s", format_error)},
      {{"of it the solver's", Align::kRight, 2}, field("solver_error_m_per_s", format_error)},
      {{"difference m/s", Align::kRight, 1}, field("velocity_difference_m_per_s", format_error)},
      {{"time"}, field("time_s", format_seconds)},
      {{"passes", Align::kRight, 4}, field("passes")}};
  say(stdout, "{}", table_text(columns, models));
  const std::size_t islands = ladder["islands"].size();
  const std::size_t shown = every_island ? islands : std::min(islands, kIslandsShown);
  if (islands > 1) {
    std::vector<TextTable::Column> headings{{"island"}, {"contacts"}};
    for (const Json& model : models) headings.push_back({model["model"], Align::kRight, 1});
    TextTable each(headings);
    for (std::size_t i = 0; i < shown; ++i) {
      std::vector<std::string> cells{std::to_string(i), std::to_string(ladder["islands"][i]["contacts"].size())};
      for (const Json& model : models) cells.push_back(field("error_m_per_s", format_error)(model["islands"][i]));
      each.add_row(cells);
    }
    say(stdout, "error by island [m/s]:\n{}", each.text(text_width()));
    if (shown < islands) say(stdout, "{} more islands: --long shows them\n", islands - shown);
  }
  say(stdout, "\n");
}

int models(const ModelsArguments& arguments) {
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  const auto examine = [&](const Problem& problem, const std::string& file, Json& documents) {
    const std::vector<LadderIsland> islands = ladder_islands(problem, file, arguments.time_limit_s);
    const std::vector<ModelRow> rows = ladder_of(islands, arguments.error, stop);
    if (*stop != 0) return;
    documents.push_back(ladder_json(problem_summary_json(problem, file), islands, rows));
    if (arguments.json) return;
    say_folded("{}\n", problem_summary_text(problem, file));
    print_ladder(documents.back(), arguments.all);
    documents.clear();
  };
  return examine_problem_files(arguments.files, arguments.json, examine);
}

}  // namespace

Action add_models_command(CLI::App& command) {
  const auto arguments = std::make_shared<ModelsArguments>();
  command.add_option("FILE", arguments->files, "problem files, or captured steps")->required();
  add_number(command, "--max-velocity-error", arguments->error,
             "m/s that cone-rough is solved to, and soft contacts give way", number_check(1e-12, 1e6));
  add_number(command, "--time-limit", arguments->time_limit_s, "seconds for each solve of an island", number_check());
  command.add_flag("--long", arguments->all, "every island");
  add_output_options(command, arguments->json);
  command.footer(
      "Solves each island of the contacts with models of friction from coarse to exact. error: the residual of the "
      "round Coulomb cone's own conditions, which needs no reference; it estimates the error of the model and ranks no "
      "answers. difference: of the velocities at the contacts "
      "from those of the cone. See docs/explanation/friction-models.md. A file that cannot be read does not stop the "
      "others; the exit code is then 2.");
  return [arguments] { return models(*arguments); };
}

}  // namespace lcpbench
