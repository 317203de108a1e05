#include "app/film_writer.h"

#include "app/say.h"
#include "scene/errors.h"
#include "scene/late_library.h"

namespace app {

std::unique_ptr<FilmWriter> openFilm(const std::string& file, int rate, int width, int height) try {
    static const auto open =
        reinterpret_cast<decltype(&revisitOpenFilm)>(scene::functionOfLibrary("librevisit_film.so", "revisitOpenFilm"));
    return std::unique_ptr<FilmWriter>(open(file.c_str(), rate, width, height));
} catch (const scene::Failure& failure) { // a walk does not end with a film
    say(failure.what());
    return nullptr;
}

} // namespace app
