#include "app/film_writer.h"

#include <dlfcn.h>

namespace app {

std::unique_ptr<FilmWriter> openFilm(const std::string& file, int rate, int width, int height) {
    // Found by the run path of the program; never unloaded, since films outlive this call.
    static void* const library = dlopen("librevisit_film.so", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return nullptr;
    static const auto open = reinterpret_cast<decltype(&revisitOpenFilm)>(dlsym(library, "revisitOpenFilm"));
    return std::unique_ptr<FilmWriter>(open != nullptr ? open(file.c_str(), rate, width, height) : nullptr);
}

} // namespace app
