#include "tests/app/made_sample.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include <unistd.h>

namespace app {

namespace {

namespace fs = std::filesystem;

/// Where samples of this very make_sample are kept; those of an older one are forgotten.
fs::path keptSamples() {
    const fs::path program = REVISIT_MAKE_SAMPLE, all = REVISIT_KEPT_SAMPLES;
    const fs::path mine = all / (std::to_string(fs::file_size(program)) + "-" +
                                 std::to_string(fs::last_write_time(program).time_since_epoch().count()));
    std::error_code ignored; // another test may do the same at this time
    if (fs::create_directories(mine, ignored))
        for (const fs::directory_entry& other : fs::directory_iterator(all, ignored))
            if (other.path() != mine) fs::remove_all(other.path(), ignored);
    return mine;
}

/// A name of its own for what is made of these arguments.
std::string nameOf(const std::vector<std::string>& arguments) {
    std::string name = "sample";
    for (std::size_t i = 1; i < arguments.size(); ++i)
        name += "_" + arguments[i];
    std::replace(name.begin(), name.end(), '/', '+');
    return name;
}

std::string textOf(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
}

} // namespace

Outcome makeSample(const std::vector<std::string>& arguments, const fs::path& scratch) {
    const fs::path kept = keptSamples() / nameOf(arguments), said = "said.txt", sample = "sample";
    if (!fs::exists(kept)) {
        const fs::path beside = kept.string() + "." + std::to_string(getpid());
        fs::create_directories(beside);
        std::vector<std::string> command{REVISIT_MAKE_SAMPLE, (beside / sample).string()};
        command.insert(command.end(), arguments.begin() + 1, arguments.end());
        const Outcome made = run(command, scratch);
        std::ofstream(beside / said) << made.output;
        std::error_code taken; // another test was first: its sample is the same
        if (made.status == 0) fs::rename(beside, kept, taken);
        std::error_code gone;
        fs::remove_all(beside, gone);
        if (made.status != 0) return made;
    }
    fs::copy(kept / sample, arguments.front(), fs::copy_options::recursive);
    return {0, textOf(kept / said)};
}

} // namespace app
