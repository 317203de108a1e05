#pragma once
// A check for options of the command line.

#include <CLI/CLI.hpp>

#include <cmath>
#include <string>

namespace app {

/// As CLI::Range of reals, which lets NaN through: it is neither below nor above.
inline CLI::Validator realRange(double least, double most) {
    const CLI::Range range(least, most);
    return CLI::Validator(
        [range](std::string& text) {
            double value = 0;
            const bool isNan = CLI::detail::lexical_cast(text, value) && std::isnan(value);
            return isNan ? text + " is not a number" : range(text);
        },
        range.get_description());
}

} // namespace app
