#include "study/inspect/inspection_output.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "study/output/json_output.h"
#include "study/output/text_table.h"

namespace lcpbench {
namespace {

std::string counted(Index count, const char* noun) { return counted_noun(static_cast<std::size_t>(count), noun); }

using Json = nlohmann::ordered_json;

std::string size_text(const Inspection& inspection) {
  std::string text = fmt::format("{}, n {}", to_string(inspection.kind), inspection.n);
  if (!inspection.contact) return text;
  return text + fmt::format(", {}, {}, {}", counted(inspection.ngc, "coordinate"), counted(inspection.nc, "contact"),
                            counted(inspection.friction_columns, "friction edge"));
}

std::string spectrum_text(const Spectrum& spectrum) {
  if (!spectrum.known()) return "not computed";
  return fmt::format("{}; eigenvalues {:.4g} to {:.4g} (+- {:.1g})", definiteness(spectrum), spectrum.smallest,
                     spectrum.largest, spectrum.rounding);
}

std::string rank_text(const Rank& rank, Index rows, Index columns) {
  if (rank.exact < 0) return "not computed";
  return fmt::format("{} exactly, {} visibly, of {} x {}", rank.exact, rank.visible, rows, columns);
}

std::string range_text(const Range& range) {
  if (std::isnan(range.low)) return "all zero";
  return fmt::format("{:.3g} to {:.3g}, a factor of {:.3g}", range.low, range.high, range.spread());
}

std::string symmetry_text(const MatrixFacts& matrix) {
  if (matrix.asymmetry == 0) return "exact";
  return fmt::format("M and its transpose differ by {:.3g} of the largest entry", matrix.asymmetry);
}

bool is_soft(const ContactFacts& contact) {
  return !std::isnan(contact.compliance_n.low) || !std::isnan(contact.compliance_t.low);
}

void add_contact_rows(const Inspection& inspection, TextTable& table) {
  const ContactFacts& contact = *inspection.contact;
  const auto row = [&table](const char* label, std::string value) { table.add_row({label, std::move(value)}); };
  row("inertia", contact.inertia + (contact.inertia_rank < 0
                                        ? ""
                                        : fmt::format(", rank {} of {}{}", contact.inertia_rank, inspection.ngc,
                                                      contact.proven_definite ? ", proven positive definite" : "")));
  if (contact.inertia_rank >= 0) {
    row("condition of the inertia",
        fmt::format("{:.3g}; {:.3g} with unit diagonal", contact.inertia_condition, contact.scaled_condition));
    row("rank of N", rank_text(contact.normals, inspection.ngc, inspection.nc));
    if (inspection.friction_columns > 0) {
      row("rank of [N D]", rank_text(contact.jacobian, inspection.ngc, inspection.nc + inspection.friction_columns));
    }
    row("M from the data", spectrum_text(contact.truth));
    row("condition of M", fmt::format("{:.3g} of the nonzero spectrum with unit diagonal", contact.condition));
  }
  if (contact.bodies > 0) row("masses [kg]", fmt::format("{} bodies, {}", contact.bodies, range_text(contact.masses)));
  row("islands", fmt::format("{}, the largest of {}", contact.islands, counted(contact.largest_island, "contact")));
  if (contact.frictional_contacts > 0) {
    row("friction", fmt::format("{}, {} with mu = 0, largest mu {:.3g}",
                                counted(contact.frictional_contacts, "contact"), contact.zero_mu, contact.largest_mu));
  }
  if (!is_soft(contact)) return;
  row("compliance r_n, r_t", range_text(contact.compliance_n) + "; " + range_text(contact.compliance_t));
}

void add_matrix_rows(const Inspection& inspection, TextTable& table) {
  const MatrixFacts& matrix = inspection.matrix;
  const auto row = [&table](const char* label, std::string value) { table.add_row({label, std::move(value)}); };
  if (!matrix.dense) {
    row("M", fmt::format("not formed: above {} unknowns", kLargestDense));
    return;
  }
  row(inspection.contact ? "M as formed in double" : "symmetric part of M", spectrum_text(matrix.symmetric));
  row("symmetry", symmetry_text(matrix));
  row("rank of M", rank_text(matrix.rank, inspection.n, inspection.n));
  if (!inspection.contact) {
    row("condition of M",
        fmt::format("{:.3g} of the symmetric part's nonzero spectrum with unit diagonal", matrix.condition));
    row("rows of M", range_text(matrix.row_sizes));
    row("columns of M", range_text(matrix.column_sizes));
    row("blocks of M", fmt::format("{}, the largest of {} unknowns", matrix.islands, matrix.largest_island));
  }
  row("diagonal of M", range_text(matrix.diagonal));
  row("class", fmt::format("Z {}, P {}, copositive {}", matrix.z_matrix ? "yes" : "no", to_string(matrix.p_matrix),
                           to_string(matrix.copositive)));
}

void add_velocity_rows(const Inspection& inspection, TextTable& table) {
  const VelocityFacts& velocity = inspection.velocity;
  const bool contact = inspection.contact.has_value();
  table.add_row(
      {contact ? "N'v [m/s]" : "q",
       fmt::format("{} negative, {} zero, {} positive; least {:.3g}, largest magnitude {:.3g}", velocity.negative,
                   velocity.zero, velocity.positive, velocity.least, velocity.largest_magnitude)});
  if (velocity.not_pressed < 0) return;
  table.add_row({contact ? "contacts never pressed" : "unknowns always zero", fmt::format("{}", velocity.not_pressed)});
}

Json rank_json(const Rank& rank) { return {{"exact", json_count(rank.exact)}, {"visible", json_count(rank.visible)}}; }

Json range_json(const Range& range) { return {{"low", json_number(range.low)}, {"high", json_number(range.high)}}; }

Json spectrum_json(const Spectrum& spectrum) {
  return {{"definiteness", spectrum.known() ? Json(definiteness(spectrum)) : Json(nullptr)},
          {"smallest", json_number(spectrum.smallest)},
          {"largest", json_number(spectrum.largest)},
          {"rounding", json_number(spectrum.rounding)},
          {"smallest_nonzero", json_number(spectrum.smallest_nonzero)},
          {"rank", json_count(spectrum.rank)}};
}

Json pairs_json(const std::vector<ContactPair>& pairs) {
  Json array = Json::array();
  for (const ContactPair& pair : pairs) {
    array.push_back({{"first", pair.first}, {"second", pair.second}, {"distance", json_number(pair.distance)}});
  }
  return array;
}

Json contact_json(const ContactFacts& contact) {
  Json json{
      {"inertia", contact.inertia},
      {"inertia_rank", json_count(contact.inertia_rank)},
      {"inertia_proven_definite", contact.proven_definite},
      {"inertia_condition", json_number(contact.inertia_rank < 0 ? Spectrum::kNone : contact.inertia_condition)},
      {"inertia_condition_scaled", json_number(contact.inertia_rank < 0 ? Spectrum::kNone : contact.scaled_condition)},
      {"rank_N", rank_json(contact.normals)},
      {"rank_J", rank_json(contact.jacobian)},
      {"spectrum_of_data", spectrum_json(contact.truth)},
      {"condition", json_number(contact.condition)},
      {"bodies", contact.bodies},
      {"masses_kg", range_json(contact.masses)},
      {"duplicates", pairs_json(contact.duplicates)},
      {"near_duplicates", pairs_json(contact.near_duplicates)},
      {"opposed", pairs_json(contact.opposed)},
      {"islands", contact.islands},
      {"largest_island", contact.largest_island},
      {"frictional_contacts", contact.frictional_contacts},
      {"zero_mu", contact.zero_mu},
      {"largest_mu", json_number(contact.largest_mu)}};
  if (is_soft(contact)) {
    json["compliance_n"] = range_json(contact.compliance_n);
    json["compliance_t"] = range_json(contact.compliance_t);
  }
  return json;
}

Json matrix_json(const MatrixFacts& matrix) {
  if (!matrix.dense) return nullptr;
  return {{"asymmetry", json_number(matrix.asymmetry)},
          {"spectrum", spectrum_json(matrix.symmetric)},
          {"condition", json_number(matrix.condition)},
          {"rank", rank_json(matrix.rank)},
          {"entries", range_json(matrix.entries)},
          {"diagonal", range_json(matrix.diagonal)},
          {"rows", range_json(matrix.row_sizes)},
          {"columns", range_json(matrix.column_sizes)},
          {"zero_rows", matrix.zero_rows},
          {"negative_diagonal", matrix.negative_diagonal},
          {"z_matrix", matrix.z_matrix},
          {"p_matrix", to_string(matrix.p_matrix)},
          {"copositive", to_string(matrix.copositive)},
          {"blocks", matrix.islands},
          {"largest_block", matrix.largest_island}};
}

Json velocity_json(const VelocityFacts& velocity) {
  return {{"negative", velocity.negative},
          {"zero", velocity.zero},
          {"positive", velocity.positive},
          {"least", json_number(velocity.least)},
          {"largest_magnitude", json_number(velocity.largest_magnitude)},
          {"ties", velocity.ties},
          {"never_pressed", json_count(velocity.not_pressed)}};
}

}  // namespace

std::string inspection_text(const Inspection& inspection, int width) {
  TextTable table({{"", TextTable::Align::kLeft, 0, 24}, {size_text(inspection), TextTable::Align::kLeft}});
  if (inspection.contact) add_contact_rows(inspection, table);
  add_matrix_rows(inspection, table);
  add_velocity_rows(inspection, table);
  std::string text = table.text(width);
  if (inspection.warnings.empty()) return text + "nothing to warn of\n";
  for (const Concern concern : {Concern::kData, Concern::kDifficulty}) {
    bool first = true;
    for (const Warning& warning : inspection.warnings) {
      if (warning.concern != concern) continue;
      if (first) text += concern == Concern::kData ? "is this what was meant?\n" : "hard on solvers:\n";
      first = false;
      text += folded(fmt::format("  {} [{}]\n", warning.text, warning.code), width);
    }
  }
  return text;
}

Json inspection_json(const Inspection& inspection) {
  Json warnings = Json::array();
  for (const Warning& warning : inspection.warnings) {
    warnings.push_back({{"code", warning.code},
                        {"concern", to_string(warning.concern)},
                        {"value", json_number(warning.value)},
                        {"message", warning.text}});
  }
  return {{"problem",
           {{"name", inspection.name},
            {"kind", to_string(inspection.kind)},
            {"n", inspection.n},
            {"ngc", inspection.contact ? Json(inspection.ngc) : Json(nullptr)},
            {"nc", inspection.contact ? Json(inspection.nc) : Json(nullptr)},
            {"edges", inspection.contact ? Json(inspection.edges) : Json(nullptr)}}},
          {"contact", inspection.contact ? contact_json(*inspection.contact) : Json(nullptr)},
          {"matrix", matrix_json(inspection.matrix)},
          {"velocity", velocity_json(inspection.velocity)},
          {"warnings", warnings}};
}

}  // namespace lcpbench
