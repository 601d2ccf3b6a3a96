// What the faulty components of the tests have in common: they behave until GO.
#pragma once

#include "picard/taskblock.h"

namespace faulty {

class Component : public picard::Taskblock {
 public:
  picard::Input<bool> go{this, "GO", "misbehave from now on"};
  picard::Output<double> out{this, "OUT", "executions"};

  void fire() override {
    out = out + 1;
    if (go) misbehave();
  }

 private:
  virtual void misbehave() = 0;
};

}  // namespace faulty
