#include "hmi/document.h"

namespace plc::hmi {

std::vector<Offer> offers_of(const Document& document) {
  std::vector<Offer> offers;
  for (const Page& page : document.pages) {
    for (const Element& element : page.elements) {
      Offer offer;
      offer.path = element.text(key("variable"));
      offer.at = element.place(key("variable"));
      switch (element.kind) {
        case Kind::kSwitch:
          break;
        case Kind::kButton:
          offer.value = element.values[key("value")];
          offer.way = offer.value.index() == 0 ? Offer::Way::kPress : Offer::Way::kValue;
          break;
        case Kind::kSlider:
          offer.way = Offer::Way::kRange;
          offer.low = element.number(key("low")).value_or(kLow);
          offer.high = element.number(key("high")).value_or(kHigh);
          break;
        case Kind::kNumber:
          if (!element.is_true(key("entered"))) continue;
          offer.way = Offer::Way::kRange;
          offer.low = element.number(key("low"));
          offer.high = element.number(key("high"));
          break;
        default:
          continue;
      }
      offers.push_back(std::move(offer));
    }
  }
  return offers;
}

}  // namespace plc::hmi
