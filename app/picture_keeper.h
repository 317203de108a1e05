#pragma once
// Screenshots and films of what a window shows, in the folder it was started in.

#include "app/film_writer.h"
#include "xr/window.h"

#include <glm/glm.hpp>

#include <chrono>
#include <memory>
#include <span>
#include <string>

namespace app {

/// What cannot be written is said on stderr; the walk goes on.
class PictureKeeper {
  public:
    PictureKeeper();
    ~PictureKeeper();

    /// revisit-DATE-TIME.png: the pictures side by side, without the panel. place: metres, the capture's own
    /// coordinates; where they are seen from is said with the name.
    void keep(std::span<const xr::WindowPicture> pictures, const glm::dvec3& place);

    /// revisit-DATE-TIME.avi (motion JPEG). False if no film can be made.
    bool beginFilm();
    /// For as long as it is shown: time in the film is time at the desk. Pictures of another size than the first end
    /// nothing: they are scaled.
    void addToFilm(std::span<const xr::WindowPicture> pictures);
    void endFilm();

  private:
    bool isFilming_ = false;
    std::unique_ptr<FilmWriter> film_; ///< from the first picture on
    std::string filmName_;
    std::chrono::steady_clock::time_point filmStart_;
    int filmFrames_ = 0;
    int filmWidth_ = 0, filmHeight_ = 0;
};

} // namespace app
