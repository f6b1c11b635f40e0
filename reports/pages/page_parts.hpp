#pragma once
#include <string>
#include <string_view>

#include "reports/kit/svg_plot.hpp"
#include "reports/kit/text.hpp"

/// Pieces of HTML that every kind of page is put together from. Content is HTML, made safe by the caller.
namespace klang::reports::detail {

std::string tag(std::string_view name, std::string_view content, std::string_view attributes = {});
/// A table cell with a number: to the right, one line. @param value  what the table sorts by, where that is not what is printed
std::string number_cell(std::string_view content, const Number& value = {});
std::string figure(const std::string& content, const std::string& caption, const std::string& name = {});
/// A drawing on its sheet, which scrolls sideways on a small screen.
std::string sheet(const Svg& svg);
std::string scrolled(const std::string& table, const std::string& label);
/// A part that opens on a click.
std::string more(const std::string& title, const std::string& content);
/// A file name for a link.
std::string encoded_path(const std::string& path);

}  // namespace klang::reports::detail
