#include "app/draw_options.h"

namespace app {

render::Quality qualityOf(const DrawOptions& o) {
    render::Quality quality = readQuality(o.quality);
    for (const auto& [name, value] : o.turned)
        turnKnob(quality, name, value, "the command line");
    if (o.hideUnseen) quality.showUnseen = false;
    return quality;
}

} // namespace app
