#include <array>
#include <charconv>
#include <cmath>

#include <nlohmann/json.hpp>

#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/settings.h"

namespace lcpbench {
namespace {

/// Builds the text by hand: the layout is for people, and shortest numbers are all that JSON needs of them.
class ProblemWriter {
 public:
  /// @param sparse  write sparse matrices and blocks as they are stored
  ProblemWriter(const Problem& problem, bool sparse) : sparse_(sparse) {
    text_ = "{\n  \"format\": \"lcpbench-problem\",\n  \"version\": 1,\n  \"name\": " +
            nlohmann::json(problem.name()).dump() + ",\n  \"kind\": \"" + to_string(problem.kind()) + "\"";
  }

  std::string finish() { return std::move(text_) + "\n}\n"; }

  void lcp(const Lcp& lcp) {
    field("M");
    rows(lcp.M, "  ");
    field("q");
    list(lcp.q);
  }

  void contact(const ContactProblem& problem) {
    field("v");
    list(problem.v);
    field("N");
    jacobian(problem.N);
    // Without a row in N nothing else would tell the number of contacts.
    if (problem.frictional() || (problem.ngc() == 0 && problem.nc() > 0)) friction(problem);
    optional("b", problem.b);
    optional("compliance_n", problem.compliance_n);
    optional("compliance_t", problem.compliance_t);
    optional("offset_t", problem.offset_t);
    std::visit([this](const auto& inertia) { this->inertia(inertia); }, problem.inertia);
  }

  void scene(const RigidScene& scene) {
    field("bodies");
    objects(scene.bodies, [this](const RigidBody& body) { this->body(body); });
    field("contacts");
    objects(scene.contacts, [this](const RigidContact& contact) { rigid_contact(contact); });
  }

 private:
  void field(const char* name) { text_ += std::string(",\n  \"") + name + "\": "; }

  void optional(const char* name, const Vector& values) {
    if (values.isZero(0)) return;
    field(name);
    list(values);
  }

  void number(double value) {
    std::array<char, 32> digits{};
    const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    text_.append(digits.data(), end);
    // "-0" is an integer to many JSON readers, and integers have no negative zero.
    if (value == 0 && std::signbit(value)) text_ += ".0";
  }

  template <class Numbers>
  void list(const Numbers& numbers) {
    text_ += '[';
    for (decltype(numbers.size()) i = 0; i < numbers.size(); ++i) {
      if (i > 0) text_ += ", ";
      number(static_cast<double>(numbers[i]));
    }
    text_ += ']';
  }

  void rows(const Matrix& matrix, const std::string& indent) {
    text_ += '[';
    for (Index row = 0; row < matrix.rows(); ++row) {
      text_ += (row == 0 ? "\n" : ",\n") + indent + "  ";
      list(matrix.row(row));
    }
    text_ += matrix.rows() == 0 ? "]" : "\n" + indent + "]";
  }

  void jacobian(const Jacobian& J) {
    const auto* sparse = std::get_if<SparseMatrix>(&J);
    if (!sparse_ || sparse == nullptr) return rows(to_dense(J), "  ");
    std::vector<Index> starts{0};
    std::vector<Index> row;
    std::vector<double> values;
    for (Index column = 0; column < sparse->outerSize(); ++column) {
      for (SparseMatrix::InnerIterator it(*sparse, column); it; ++it) {
        row.push_back(it.row());
        values.push_back(it.value());
      }
      starts.push_back(static_cast<Index>(row.size()));
    }
    text_ += "{\n    \"starts\": ";
    list(starts);
    text_ += ",\n    \"rows\": ";
    list(row);
    text_ += ",\n    \"values\": ";
    list(values);
    text_ += "\n  }";
  }

  void friction(const ContactProblem& problem) {
    field("D");
    jacobian(problem.D);
    field("edges");
    Vector edges(problem.nc());
    for (Index i = 0; i < problem.nc(); ++i) edges(i) = problem.edges[static_cast<std::size_t>(i)];
    list(edges);
    field("mu");
    list(problem.mu);
  }

  void inertia(const DenseInertia& inertia) {
    field("G");
    rows(inertia.G, "  ");
  }
  void inertia(const BlockInertia& inertia) {
    if (!sparse_) return this->inertia(DenseInertia{dense_inertia(inertia)});
    field("G_blocks");
    text_ += '[';
    for (std::size_t i = 0; i < inertia.blocks.size(); ++i) {
      text_ += i == 0 ? "\n    " : ",\n    ";
      rows(inertia.blocks[i], "    ");
    }
    text_ += "\n  ]";
  }
  void inertia(const FactoredInertia& inertia) {
    text_ += ",\n  \"G_factors\": {\n    \"X\": ";
    rows(inertia.X, "    ");
    text_ += ",\n    \"alpha\": ";
    list(inertia.alpha);
    text_ += "\n  }";
  }
  void inertia(const InverseInertia& inertia) {
    field("Ginv");
    rows(inertia.Ginv, "  ");
  }

  template <class Item, class Write>
  void objects(const std::vector<Item>& items, const Write& write) {
    text_ += '[';
    for (std::size_t i = 0; i < items.size(); ++i) {
      text_ += i == 0 ? "\n    {" : ",\n    {";
      write(items[i]);
      text_ += '}';
    }
    text_ += items.empty() ? "]" : "\n  ]";
  }

  void item(const char* name, double value) {
    text_ += std::string("\"") + name + "\": ";
    number(value);
  }
  void item(const char* name, const Eigen::Vector3d& value) {
    text_ += std::string(", \"") + name + "\": ";
    list(value);
  }

  void body(const RigidBody& body) {
    item("mass", body.mass);
    text_ += ", \"inertia\": [";
    for (Index row = 0; row < 3; ++row) {
      if (row > 0) text_ += ", ";
      list(body.inertia.row(row));
    }
    text_ += ']';
    item("position", body.position);
    item("linear_velocity", body.linear_velocity);
    item("angular_velocity", body.angular_velocity);
  }

  void rigid_contact(const RigidContact& contact) {
    item("body_a", contact.body_a);
    text_ += ", ";
    item("body_b", contact.body_b);
    item("point", contact.point);
    item("normal", contact.normal);
    if (contact.edges != 0) {
      item("tangent", contact.tangent);
      text_ += ", ";
      item("mu", contact.mu);
      text_ += ", ";
      item("edges", contact.edges);
    }
    const auto optional = [this](const char* name, double value) {
      if (value == 0) return;
      text_ += ", ";
      item(name, value);
    };
    optional("b", contact.b);
    optional("compliance_n", contact.compliance_n);
    optional("compliance_t", contact.compliance_t);
    if (contact.offset_t.isZero(0)) return;
    text_ += ", \"offset_t\": ";
    list(contact.offset_t);
  }

  std::string text_;
  bool sparse_;
};

/// Numbers and rows that the reader will count, an upper bound; in double because a sparse problem's may overflow.
double numbers(const Lcp& lcp) {
  const auto n = static_cast<double>(lcp.size());
  return n * n + 2 * n;
}

double numbers(const Jacobian& J, bool sparse) {
  const auto* matrix = std::get_if<SparseMatrix>(&J);
  const auto columns = static_cast<double>(cols(J));
  if (sparse && matrix != nullptr) return 2 * static_cast<double>(matrix->nonZeros()) + columns + 1;
  return static_cast<double>(rows(J)) * (columns + 1);
}

double numbers(const Inertia& inertia, bool sparse) {
  const auto ngc = static_cast<double>(dimension(inertia));
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    return (ngc + 1) * static_cast<double>(factors->X.cols()) + ngc;
  }
  const auto* separate = std::get_if<BlockInertia>(&inertia);
  if (!sparse || separate == nullptr) return ngc * (ngc + 1);
  double total = 0;
  for (const Matrix& block : separate->blocks) {
    total += static_cast<double>(block.size()) + static_cast<double>(block.rows()) + 1;
  }
  return total;
}

double numbers(const ContactProblem& problem, bool sparse) {
  return static_cast<double>(problem.ngc()) + numbers(problem.N, sparse) + numbers(problem.D, sparse) +
         numbers(problem.inertia, sparse) + 8 * static_cast<double>(problem.nc());
}

/// What the reader would refuse is not written.
void check_numbers(double numbers, const std::string& origin) {
  if (numbers <= static_cast<double>(kMaxNumbers)) return;
  throw input_error(origin, "too large for a problem file: " + format_real(numbers) + " numbers, at most " +
                                std::to_string(kMaxNumbers) + " are allowed");
}

/// A file with dense matrices is easier to read, and up to about a megabyte it does not matter that it is larger.
constexpr double kMaxReadableNumbers = 1 << 16;

enum class Sparse { kNever, kLarge, kAlways };

std::string text_of(const Problem& problem, Sparse form) {
  const std::string origin = problem.name().empty() ? "unnamed problem" : problem.name();
  check_name(problem.name(), origin);
  const ContactProblem* contact = problem.kind() == ProblemKind::kContact ? problem.contact() : nullptr;
  const bool is_large = contact != nullptr && numbers(*contact, false) > kMaxReadableNumbers;
  const bool sparse = contact != nullptr && (form == Sparse::kAlways || (form == Sparse::kLarge && is_large));
  ProblemWriter writer(problem, sparse);
  if (problem.kind() == ProblemKind::kScene) {
    check_scene(*problem.scene(), origin);
    writer.scene(*problem.scene());
  } else if (contact != nullptr) {
    check_numbers(numbers(*contact, sparse), origin);
    check_contact(*contact, origin);
    writer.contact(*contact);
  } else {
    check_numbers(numbers(problem.lcp()), origin);
    check_lcp(problem.lcp(), origin);
    writer.lcp(problem.lcp());
  }
  return writer.finish();
}

}  // namespace

std::string problem_json(const Problem& problem) { return text_of(problem, Sparse::kLarge); }

std::string problem_json_line(const Problem& problem, bool dense) {
  const std::string text = text_of(problem, dense ? Sparse::kNever : Sparse::kAlways);
  std::string line;
  line.reserve(text.size());
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') in_string = !in_string;
    if (!in_string && (c == ' ' || c == '\n')) continue;
    line += c;
    if (in_string && c == '\\') line += text[++i];
  }
  return line;
}

}  // namespace lcpbench
