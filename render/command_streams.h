#pragma once
// Where commands are recorded: per frame in flight and eye one pool and one command buffer, so that the eyes record at
// the same time, and per frame one fence, so that nobody waits but for the frame two before.

#include "render/device.h"
#include "render/handle.h"
#include "render/target.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace render {

/// A command buffer and the pool it alone is of, which is reset whole.
struct Recorder {
    CommandPool pool;
    VkCommandBuffer commands = VK_NULL_HANDLE;
};
Recorder makeRecorder(const Device& device);

Fence makeFence(const Device& device, VkFenceCreateFlags flags);

class CommandStreams {
  public:
    CommandStreams(const Device& device, int eyes);
    /// Waits until nothing that was submitted is still running.
    ~CommandStreams();
    CommandStreams(const CommandStreams&) = delete;
    CommandStreams& operator=(const CommandStreams&) = delete;

    /// Waits until the frame that used this slot (0 to kFramesInFlight - 1) before has finished.
    void wait(std::size_t slot);
    /// Whether it has; does not wait.
    bool isDone(std::size_t slot) const;
    /// Waits for the frames of all slots: what they used may then go.
    void waitForAll();
    /// Starts an eye's commands anew; the slot must have been waited for. Different eyes may be recorded by
    /// different threads.
    VkCommandBuffer begin(std::size_t slot, int eye);
    /// Ends and submits all eyes of a slot, the left one first: what it draws may be for both.
    void submit(std::size_t slot);

  private:
    struct Slot {
        std::vector<Recorder> eyes;
        Fence finished; ///< signalled while nothing is running
    };
    const Device& device_;
    std::array<Slot, kFramesInFlight> slots_;
};

/// Records commands, submits them and waits until they are done: for what happens once.
void runAndWait(const Device& device, const std::function<void(VkCommandBuffer)>& recordCommands);

// The stages and accesses of most barriers, by short names.
inline constexpr VkPipelineStageFlags kCompute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
inline constexpr VkPipelineStageFlags kTransfer = VK_PIPELINE_STAGE_TRANSFER_BIT;
inline constexpr VkAccessFlags kRead = VK_ACCESS_SHADER_READ_BIT, kWrite = VK_ACCESS_SHADER_WRITE_BIT;

/// What was written or read at some stages is finished and visible before others read or write.
struct Barrier {
    VkPipelineStageFlags fromStages = 0;
    VkAccessFlags fromAccess = 0;
    VkPipelineStageFlags toStages = 0;
    VkAccessFlags toAccess = 0;
};
void record(VkCommandBuffer commands, const Barrier& barrier);

} // namespace render
