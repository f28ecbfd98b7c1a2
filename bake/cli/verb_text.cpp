// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/verb_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string_view>

#include "bake/cli/terminal.h"

namespace photic::cli {

namespace {

constexpr int kIndent = 2, kNamesColumn = 30;

std::vector<std::string> linesOf(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

/// Words of `text` in lines that begin at `indent` and end before `columns`; the first continues a line at `at`.
std::string wrapped(const std::string& text, int at, int indent, int columns) {
    std::string out;
    std::istringstream in(text);
    bool first = true;
    for (std::string word; in >> word; first = false) {
        const int length = static_cast<int>(word.size());
        if (!first && at + 1 + length > columns) {
            out += '\n';
            out.append(static_cast<std::size_t>(indent), ' ');
            at = indent;
        } else if (!first) {
            out += ' ', ++at;
        }
        out += word, at += length;
    }
    return out;
}

std::string heading(const std::string& text, const PageStyle& style) {
    return style.colour ? fmt::format("\033[1m{}\033[0m\n", text) : text + "\n";
}

std::string namesOf(const OptionText& option) {
    std::string names = fmt::format("{}", fmt::join(option.names, ", "));
    if (!option.value.empty() && !option.argument) names += " " + option.value;
    return names;
}

/// "  --name VALUE   help", wrapped under the help's own column.
std::string entry(const std::string& names, const std::string& help, const PageStyle& style) {
    const int column = std::min(kNamesColumn, style.columns / 2);
    std::string line(kIndent, ' ');
    line += names;
    int at = static_cast<int>(line.size());
    if (at + 2 > column) {
        line += '\n';
        line.append(static_cast<std::size_t>(column), ' ');
    } else {
        line.append(static_cast<std::size_t>(column - at), ' ');
    }
    return fmt::format("{}{}\n", line, wrapped(help, column, column, style.columns));
}

std::string usageOf(const VerbText& verb) {
    std::string usage = "photic " + verb.name;
    for (const OptionText& option : verb.options) {
        if (!option.argument && option.required) usage += fmt::format(" {} {}", option.names.front(), option.value);
    }
    usage += " [OPTIONS]";
    for (const OptionText& option : verb.options) {
        if (option.argument) usage += " " + option.names.front() + (option.repeats ? "..." : "");
    }
    return usage;
}

/// Notes keep their lines' indents and are wrapped within them.
std::string notesPage(const std::string& notes, const PageStyle& style) {
    std::string page;
    for (const std::string& line : linesOf(notes)) {
        const auto indent = static_cast<int>(std::min(line.find_first_not_of(' '), line.size()));
        page += fmt::format("{}{}\n", line.substr(0, static_cast<std::size_t>(indent)),
                            wrapped(line, indent, indent + 4, style.columns));
    }
    return page;
}

}  // namespace

std::vector<std::string> OptionText::choices() const {
    if (value.find('|') == std::string::npos) return {};
    std::vector<std::string> words;
    std::istringstream in(value);
    for (std::string word; std::getline(in, word, '|');) words.push_back(word);
    return words;
}

PageStyle pageStyle() {
    PageStyle style;
    winsize size{};
    const bool terminal = isatty(STDOUT_FILENO) != 0;
    if (terminal && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) style.columns = size.ws_col;
    // As shells set it; also how a page is laid out for a pipe.
    if (const char* columns = std::getenv("COLUMNS")) {
        if (const int given = std::atoi(columns); given > 0) style.columns = given;
    }
    style.columns = std::clamp(style.columns, 40, 160);
    style.colour = wantsColour(STDOUT_FILENO);
    return style;
}

std::string helpPage(const ProgramText& program, const PageStyle& style) {
    std::string page =
        fmt::format("{}\n\n{}  photic VERB [OPTIONS] ...\n  photic help VERB\n\n{}",
                    wrapped(program.summary, 0, 0, style.columns), heading("Usage:", style), heading("Verbs:", style));
    for (const VerbText& verb : program.verbs) page += entry(verb.name, verb.summary, style);
    page +=
        fmt::format("\n{}  photic bake pool.toml -o out/pool.vdb\n  photic picture pool.toml out/pool.vdb -o out\n\n",
                    heading("First steps:", style));
    page += entry("-h, --help", "This page; after a verb, its own", style);
    page += entry("-V, --version", "The program's version", style);
    return fmt::format("{}\n{}\n", page, wrapped(program.exit_codes, 0, 0, style.columns));
}

std::string helpPage(const VerbText& verb, const PageStyle& style) {
    std::string page = fmt::format("{}\n\n{}  {}\n", wrapped(verb.summary + ".", 0, 0, style.columns),
                                   heading("Usage:", style), wrapped(usageOf(verb), 2, 6, style.columns));
    if (!verb.examples.empty())
        page += fmt::format("\n{}", heading(verb.examples.size() == 1 ? "Example:" : "Examples:", style));
    for (const std::string& example : verb.examples) page += fmt::format("  {}\n", example);
    for (const bool argument : {true, false}) {
        const auto kind = [&](const OptionText& option) { return option.argument == argument; };
        if (std::none_of(verb.options.begin(), verb.options.end(), kind)) continue;
        page += fmt::format("\n{}", heading(argument ? "Arguments:" : "Options:", style));
        for (const OptionText& option : verb.options) {
            if (kind(option)) page += entry(namesOf(option), option.help, style);
        }
    }
    if (!verb.notes.empty()) page += fmt::format("\n{}", notesPage(verb.notes, style));
    return page;
}

}  // namespace photic::cli
