#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "study/output/json_output.h"
#include "study/store/sqlite.h"

// The tables of a report are queries, study/report/tables/*.sql. They read the store's own tables and views, and
// temporary tables of the connection, which fill_tables() in study/report/report.h fills.

namespace lcpbench::report {

/// A file of study/report/tables. Its first lines are comments: the title, then what the table says. A line "-- only in
/// tables/" keeps the rows out of report.json: there are many.
struct TableQuery {
  const char* name;
  std::string_view sql;
};

/// All of them, in the order of their names.
extern const std::vector<TableQuery> kTableQueries;
/// The one of this name, else null.
const TableQuery* find_table(std::string_view name);

/// study/report/views.sql: views over the temporary tables, for queries and for the terminal.
extern const std::string_view kViews;

/// The content of study/report/page/page.html.
extern const std::string_view kPage;
/// The page with a document in it, of docs/schema/report.schema.json: one file of HTML that needs nothing else. No text
/// of the document ends the element that holds it.
std::string page_html(const Json& document);

/// Columns and rows of a query; NULL and NaN are null.
struct QueryResult {
  std::vector<std::string> columns;
  std::vector<Json> rows;  ///< arrays
};

/// Makes a temporary table of records whose columns are all their members, those of members in members with a dot
/// between the names. No records: a table with the columns of `example`.
/// @param records  array of objects
void fill_table(sqlite::Database& database, const std::string& name, const Json& records, const Json& example = {});

/// Runs one SELECT. @param name  what a message calls it. @throws InputError for anything else, or for an error in it.
QueryResult run_query(sqlite::Database& database, const std::string& name, std::string_view sql);

/// The rows as objects. Of columns with the same name only the last is kept.
Json records_of(const QueryResult& result);

/// A value for the page, or an array of values. Floating-point numbers have six digits: a page is read, tables/ are
/// computed with. An integer that JavaScript would round, as a seed may be, is its text.
Json page_value(Json value);

/// {"name","title","about","columns":[{"name","unit"}],"rows","sql"}; without "rows" where the file asks for that.
Json table_json(const TableQuery& query, const QueryResult& result);

}  // namespace lcpbench::report
