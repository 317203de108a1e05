#include "tests/app/program.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace app {

namespace {

std::string contentOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

} // namespace

pid_t start(const std::vector<std::string>& command, const std::filesystem::path& outputFile) {
    std::vector<char*> arguments;
    for (const std::string& word : command)
        arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    const pid_t process = fork();
    if (process == 0) {
        const int file = open(outputFile.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        dup2(file, STDOUT_FILENO);
        dup2(file, STDERR_FILENO);
        execv(arguments[0], arguments.data());
        _exit(127);
    }
    return process;
}

Outcome waitFor(pid_t process, const std::filesystem::path& outputFile) {
    int status = 0;
    waitpid(process, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), contentOf(outputFile)};
}

Outcome run(const std::vector<std::string>& command, const std::filesystem::path& scratch) {
    const std::filesystem::path outputFile = scratch / "output.txt";
    return waitFor(start(command, outputFile), outputFile);
}

std::vector<std::pair<std::string, std::string>> filesOf(const std::filesystem::path& folder) {
    std::vector<std::pair<std::string, std::string>> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            files.emplace_back(std::filesystem::relative(entry.path(), folder).string(), contentOf(entry.path()));
    std::sort(files.begin(), files.end());
    return files;
}

} // namespace app
