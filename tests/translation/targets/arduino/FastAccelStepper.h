// A stand-in for the library FastAccelStepper, for tests: the calls that translated sketches use, and what they promise.
//
// Written from the description of the calls, without the library's code, on top of the stand-in for AccelStepper: it steps
// in the calls that block, and in isRunning(); the library steps in interrupts of timer 1.
#pragma once

#include <new.h>

#include "AccelStepper.h"

class FastAccelStepper {
 public:
  explicit FastAccelStepper(uint8_t step) : step_(step) {}
  void setDirectionPin(uint8_t dir) { stepper_ = new (place_) AccelStepper(AccelStepper::DRIVER, step_, dir); }
  int8_t setSpeedInMilliHz(uint32_t rate) { return stepper_->setMaxSpeed(rate / 1000.0f), 0; }
  int8_t setAcceleration(int32_t acceleration) { return stepper_->setAcceleration(acceleration), 0; }
  int32_t getCurrentPosition() { return stepper_->currentPosition(); }
  void setCurrentPosition(int32_t position) { stepper_->setCurrentPosition(position); }
  int8_t move(int32_t steps, bool blocking = false) { return moveTo(stepper_->currentPosition() + steps, blocking); }
  int8_t moveTo(int32_t position, bool blocking = false) {
    stepper_->moveTo(position);
    if (blocking) stepper_->runToPosition();
    return 0;
  }
  int8_t runForward() { return moveTo(2000000000L); }
  int8_t runBackward() { return moveTo(-2000000000L); }
  void stopMove() { stepper_->stop(); }
  bool isRunning() { return stepper_->run(); }

 private:
  uint8_t step_;
  AccelStepper *stepper_ = NULL;
  alignas(AccelStepper) uint8_t place_[sizeof(AccelStepper)];
};

class FastAccelStepperEngine {
 public:
  void init() {}
  FastAccelStepper *stepperConnectToPin(uint8_t step) {
    static FastAccelStepper stepper(step);
    return &stepper;
  }
};
