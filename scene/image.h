#pragma once
// A picture of values of one type, row by row from the top left; owned once, lent as a view.

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace scene {

struct Rgb8 {
    std::uint8_t r = 0, g = 0, b = 0;
    friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

/// A window on somebody else's pixels. rowStride is in values, not bytes.
template <class T>
struct ImageView {
    T* pixels = nullptr;
    int width = 0, height = 0;
    std::ptrdiff_t rowStride = 0;

    T& operator()(int x, int y) const {
        assert(x >= 0 && x < width && y >= 0 && y < height);
        return pixels[y * rowStride + x];
    }
    std::span<T> row(int y) const { return {pixels + y * rowStride, static_cast<std::size_t>(width)}; }
};

template <class T>
class Image {
  public:
    Image() = default;
    Image(int width, int height, T value = {})
        : width_(width), height_(height),
          pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), value) {}

    int width() const { return width_; }
    int height() const { return height_; }
    bool empty() const { return pixels_.empty(); }
    std::size_t size() const { return pixels_.size(); }

    T& operator()(int x, int y) { return pixels_[index(x, y)]; }
    const T& operator()(int x, int y) const { return pixels_[index(x, y)]; }
    std::span<T> row(int y) { return {&pixels_[index(0, y)], static_cast<std::size_t>(width_)}; }
    std::span<const T> row(int y) const { return {&pixels_[index(0, y)], static_cast<std::size_t>(width_)}; }
    std::span<T> pixels() { return pixels_; }
    std::span<const T> pixels() const { return pixels_; }

    // NOLINTNEXTLINE(google-explicit-constructor): to lend is no conversion that could surprise
    operator ImageView<const T>() const { return {pixels_.data(), width_, height_, width_}; }
    ImageView<T> view() { return {pixels_.data(), width_, height_, width_}; }
    ImageView<const T> view() const { return *this; }

    friend bool operator==(const Image&, const Image&) = default;

  private:
    std::size_t index(int x, int y) const {
        assert(x >= 0 && x < width_ && y >= 0 && y < height_);
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    int width_ = 0, height_ = 0;
    std::vector<T> pixels_;
};

} // namespace scene
