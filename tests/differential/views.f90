!> Scenes as texts that stand for themselves in any view: mirrored, turned, moved, in other units, at another time, under other
!> names. What changes with the view stands in `<...>` of a block:
!>
!>    <N|name>              a name, or name.point; with `ground` it stays
!>    <C|first|second>      two points of a joint or spring that may stand in either order
!>    <D|m,l,t|+|number>    a number of dimension mass^m length^l time^t; -: one that a mirror turns about
!>    <X|x|y>, <Y|x|y>      a place;  <U|l,m,t|x|y>, <V|...>: a vector
!>    <A|number>            an angle from the x axis
!>    <S|a|b|number>        the angle of body a less that of body b; nobody: a direction in space
!>    <K|a|b|number>        the same where a and b may stand in either order
!>    <Z|number>            an instant
!>    <E|m,l,t|+|law>, <B|law>, <T|a|b|law>, <F|m,l,t|law|law>, <G|...>, <P|law|law>, <Q|...>
!>                          laws of: a number, an angle, a relative angle, a vector's x and y, a place's x and y
!>    <R|l,m,t|+|law>       as E, of a motion: not changed where loads are
!>    <L|X|Y>, <W|law>      X or Y, the axis that was x, of views by quarters; a law of what was x
!>    <M|a|b>               word a, and b in a mirror
!>    <J|n|m>               options of an exact beam with n functions of the angle and m of the strain
!>    <O>, <H>, <I>         options of *DYNAMICS and of *ASSEMBLY; *ACCURACY
!>
!> and in laws {t}, {x:point}, {y:point}, {vx:point}, {vy:point}, {ang:body}, {spin:body}, {el}, {rate} of springs along a line,
!> {elr}, {rater} of rotational ones, {s} along a beam, {cx} along a curve.
module views
   use limber_base_kinds, only: wp
   use limber_base_text, only: as_text, newline
   implicit none
   private
   public :: view_type, block_type, channel_type, rendered, asked, seen_again
   public :: of_place, of_vector, of_number, of_change, mentions

   !> How a scene is looked at, and run
   type :: view_type
      character(24) :: name = 'base'
      !> -1 in a mirror (about the x axis, before it is turned)
      real(wp) :: side = 1.0_wp
      !> Turned by cosine and sine of an angle [rad]; moved behind that
      real(wp) :: turn = 0.0_wp, cosine = 1.0_wp, sine = 0.0_wp, moved(2) = 0.0_wp
      !> Mass, length, time in the new units
      real(wp) :: units(3) = 1.0_wp
      !> Time at the start
      real(wp) :: start = 0.0_wp
      logical :: renamed = .false., exchanged = .false., eliminated = .true., estimated = .false.
      !> Order of the blocks; 0: as they are
      integer :: order = 0
      !> Relative change of masses, stiffnesses and loads
      real(wp) :: change = 0.0_wp
      character(10) :: integrator = 'AUTO'
      real(wp) :: tolerance = 1.0e-6_wp
      !> Error that limber is to keep, with the functions of exact beams, the integrator and the tolerance left to it; 0: none
      real(wp) :: target = 0.0_wp
      !> Functions of all exact beams, of the angle and of the strain; 0: each has its own
      integer :: functions(2) = 0
      !> Counts the numbers that are changed
      integer :: changed = 0
   end type view_type

   !> A block of a deck
   type :: block_type
      !> Name of what it defines; empty if nothing
      character(12) :: name = ''
      !> 1: head, 2: of the scene, 3: analyses and output
      integer :: part = 2
      character(:), allocatable :: text
   end type block_type

   integer, parameter :: of_place = 1, of_vector = 2, of_number = 3, of_change = 4

   !> One or two quantities: of a place or vector x and y
   type :: channel_type
      character(:), allocatable :: first, second
      integer :: kind = of_number
      integer :: dimension(3) = 0
      !> -1: a mirror turns it about
      real(wp) :: sign = 1.0_wp
      !> Part of a full turn of the view that it has, as angles from the ground do
      real(wp) :: turned = 0.0_wp
      !> Whether it changes its sign where joints exchange their sides; whether it depends on the place of the origin
      logical :: swaps = .false., placed = .false.
      !> Object that it is asked of
      character(12) :: of = ''
      !> What its errors are compared with besides itself: all of a group
      integer :: group = 0
   end type channel_type

contains

   !> A block as it stands in a deck.
   recursive function rendered(text, view) result(out)
      character(*), intent(in) :: text
      type(view_type), intent(inout) :: view
      character(:), allocatable :: out
      integer :: at, last
      out = ''
      at = 1
      do while (at <= len(text))
         if (text(at:at) /= '<') then
            last = scan(text(at:), '<')
            last = merge(len(text), at + last - 2, last == 0)
            out = out//text(at:last)
         else
            last = at + index(text(at:), '>') - 1
            out = out//field(text(at + 1:last - 1), view)
         end if
         at = last + 1
      end do
   end function rendered

   !> What stands for a field.
   recursive function field(text, view) result(out)
      character(*), intent(in) :: text
      type(view_type), intent(inout) :: view
      character(:), allocatable :: out
      real(wp) :: factor, p(2)
      select case (text(1:1))
      case ('N'); out = name_of(word(text, 2), view)
      case ('C')
         out = name_of(word(text, 2), view)//', '//name_of(word(text, 3), view)
         if (view%exchanged) out = name_of(word(text, 3), view)//', '//name_of(word(text, 2), view)
      case ('D')
         factor = scale_of(word(text, 2), view)*sign_of(word(text, 3), view)
         if (heavy(word(text, 2))) factor = factor*disturbance(view)
         out = scaled(word(text, 4), factor)
      case ('X', 'Y')
         p = seen_place([value(word(text, 2)), value(word(text, 3))], view)
         out = coordinate(text, word(text, 2), word(text, 3), p, view)
      case ('U', 'V')
         p = scale_of(word(text, 2), view)*seen([value(word(text, 3)), value(word(text, 4))], view)
         if (abs(view%change) > 0.0_wp) p = p*disturbance(view)
         out = coordinate(text, word(text, 3), word(text, 4), p, view)
      case ('A'); out = added(word(text, 2), view%side, view%turn)
      case ('S'); out = added(word(text, 4), view%side, view%turn*grounded(word(text, 2), word(text, 3)))
      case ('K')
         out = added(word(text, 4), view%side*merge(-1.0_wp, 1.0_wp, view%exchanged), view%turn*grounded(word(text, 2), &
            & word(text, 3))*merge(-1.0_wp, 1.0_wp, view%exchanged))
      case ('Z'); out = added(word(text, 2), view%units(3), view%start)
      case ('E')
         factor = scale_of(word(text, 2), view)*sign_of(word(text, 3), view)*disturbance(view)
         out = times(factor, law(word(text, 4), view))
      case ('R'); out = times(scale_of(word(text, 2), view)*sign_of(word(text, 3), view), law(word(text, 4), view))
      case ('B'); out = plus(times(view%side, law(word(text, 2), view)), view%turn)
      case ('T'); out = plus(times(view%side, law(word(text, 4), view)), view%turn*grounded(word(text, 2), word(text, 3)))
      case ('F', 'G')
         factor = scale_of(word(text, 2), view)*disturbance(view)
         out = mixed(text(1:1) == 'F', factor, law(word(text, 3), view), law(word(text, 4), view), view)
      case ('P', 'Q')
         out = mixed(text(1:1) == 'P', view%units(2), law(word(text, 2), view), law(word(text, 3), view), view)
         out = plus(out, view%units(2)*view%moved(merge(1, 2, text(1:1) == 'P')))
      case ('L'); out = merge('X', 'Y', abs(view%cosine) > 0.5_wp)
      case ('W')
         factor = merge(view%cosine, view%sine, abs(view%cosine) > 0.5_wp)
         out = plus(times(view%units(2)*factor, law(word(text, 2), view)), &
            & view%units(2)*view%moved(merge(1, 2, abs(view%cosine) > 0.5_wp)))
      case ('M'); out = word(text, merge(3, 2, view%side < 0.0_wp))
      case ('J')
         out = ', GEOMETRIC=EXACT, FUNCTIONS='//word(text, 2)//', STRAIN FUNCTIONS='//word(text, 3)
         if (view%functions(1) > 0) out = ', GEOMETRIC=EXACT, FUNCTIONS='//as_text(view%functions(1))//', STRAIN FUNCTIONS='// &
            & as_text(view%functions(2))
         if (view%target > 0.0_wp) out = ''
      case ('O')
         out = ', TOLERANCE='//short(view%tolerance)//', INTEGRATOR='//trim(view%integrator)
         if (view%target > 0.0_wp) out = ''
      case ('H'); out = merge(', ELIMINATION=YES', ', ELIMINATION=NO ', view%eliminated)
      case ('I')
         out = trim(merge('YES', 'NO ', view%estimated))
         if (view%target > 0.0_wp) out = out//', TARGET='//short(view%target)
      case default; error stop 'a field that nobody knows'
      end select
   end function field

   !> Part of a field, between bars.
   pure function word(text, number) result(out)
      character(*), intent(in) :: text
      integer, intent(in) :: number
      character(:), allocatable :: out
      integer :: first, i, step
      first = 1
      do i = 2, number
         first = first + index(text(first:), '|')
      end do
      step = index(text(first:)//'|', '|')
      out = text(first:first + step - 2)
   end function word

   !> A name in the view.
   pure function name_of(text, view) result(out)
      character(*), intent(in) :: text
      type(view_type), intent(in) :: view
      character(:), allocatable :: out
      integer :: dot
      out = text
      if (.not. view%renamed) return
      dot = index(text//'.', '.')
      if (text(:dot - 1) == 'ground') return
      out = 'z_'//text(1:1)//'_'//text
   end function name_of

   pure real(wp) function scale_of(dimension, view) result(factor)
      character(*), intent(in) :: dimension
      type(view_type), intent(in) :: view
      integer :: powers(3)
      read (dimension, *) powers
      factor = product(view%units**powers)
   end function scale_of

   !> Whether a number is of those that a change of the scene changes.
   pure logical function heavy(dimension)
      character(*), intent(in) :: dimension
      integer :: powers(3)
      read (dimension, *) powers
      heavy = powers(1) == 1
   end function heavy

   !> Factor of the next number where the scene is changed a little: more, and less, by turns.
   real(wp) function disturbance(view) result(factor)
      type(view_type), intent(inout) :: view
      factor = 1.0_wp
      if (.not. abs(view%change) > 0.0_wp) return
      view%changed = view%changed + 1
      factor = 1.0_wp + view%change*merge(1.0_wp, -0.5_wp, mod(view%changed, 2) == 1)
   end function disturbance

   pure real(wp) function sign_of(text, view) result(factor)
      character(*), intent(in) :: text
      type(view_type), intent(in) :: view
      factor = merge(view%side, 1.0_wp, text == '-')
   end function sign_of

   pure real(wp) function value(text)
      character(*), intent(in) :: text
      read (text, *) value
   end function value

   !> A vector in the view.
   pure function seen(vector, view) result(out)
      real(wp), intent(in) :: vector(2)
      type(view_type), intent(in) :: view
      real(wp) :: out(2)
      out = [view%cosine*vector(1) - view%sine*view%side*vector(2), view%sine*vector(1) + view%cosine*view%side*vector(2)]
   end function seen

   !> A place in the view.
   pure function seen_place(place, view) result(out)
      real(wp), intent(in) :: place(2)
      type(view_type), intent(in) :: view
      real(wp) :: out(2)
      out = view%units(2)*(seen(place, view) + view%moved)
   end function seen_place

   pure logical function is_plain(view)
      type(view_type), intent(in) :: view
      is_plain = view%side > 0.0_wp .and. abs(view%turn) <= 0.0_wp .and. all(abs(view%moved) <= 0.0_wp) .and. &
         & all(abs(view%units - 1.0_wp) <= 0.0_wp) .and. .not. abs(view%change) > 0.0_wp
   end function is_plain

   !> A coordinate: as it is written where the view changes nothing.
   pure function coordinate(text, x, y, p, view) result(out)
      character(*), intent(in) :: text, x, y
      real(wp), intent(in) :: p(2)
      type(view_type), intent(in) :: view
      character(:), allocatable :: out
      if (scan(text(1:1), 'XU') == 1) then
         out = number(p(1))
         if (is_plain(view)) out = x
      else
         out = number(p(2))
         if (is_plain(view)) out = y
      end if
   end function coordinate

   !> A number with all its digits.
   pure function number(x) result(out)
      real(wp), intent(in) :: x
      character(:), allocatable :: out
      character(26) :: text
      write (text, '(es24.16e3)') x
      out = trim(adjustl(text))
      if (abs(x) <= 0.0_wp) out = '0'
   end function number

   !> A number with few digits.
   pure function short(x) result(out)
      real(wp), intent(in) :: x
      character(:), allocatable :: out
      character(16) :: text
      write (text, '(es8.1)') x
      out = trim(adjustl(text))
   end function short

   pure function scaled(text, factor) result(out)
      character(*), intent(in) :: text
      real(wp), intent(in) :: factor
      character(:), allocatable :: out
      out = text
      if (abs(factor - 1.0_wp) > 0.0_wp) out = number(factor*value(text))
   end function scaled

   pure function added(text, factor, more) result(out)
      character(*), intent(in) :: text
      real(wp), intent(in) :: factor, more
      character(:), allocatable :: out
      out = text
      if (abs(factor - 1.0_wp) > 0.0_wp .or. abs(more) > 0.0_wp) out = number(factor*value(text) + more)
   end function added

   !> +1, 0 or -1: how the angle of body a less that of body b changes with a turn of all but the ground.
   pure real(wp) function grounded(a, b)
      character(*), intent(in) :: a, b
      grounded = merge(-1.0_wp, 0.0_wp, stays(a)) + merge(1.0_wp, 0.0_wp, stays(b))

   contains

      !> Point masses have the axes of space, too
      pure logical function stays(name)
         character(*), intent(in) :: name
         stays = name == 'ground'
         if (len(name) > 1) stays = stays .or. (name(1:1) == 'p' .and. scan(name(2:2), '0123456789') == 1)
      end function stays

   end function grounded

   pure function times(factor, text) result(out)
      real(wp), intent(in) :: factor
      character(*), intent(in) :: text
      character(:), allocatable :: out
      out = text
      if (abs(factor - 1.0_wp) > 0.0_wp) out = number(factor)//'*('//text//')'
   end function times

   pure function plus(text, more) result(out)
      character(*), intent(in) :: text
      real(wp), intent(in) :: more
      character(:), allocatable :: out
      out = text
      if (abs(more) > 0.0_wp) out = text//' + ('//number(more)//')'
   end function plus

   !> x or y of a vector of laws.
   pure function mixed(first, factor, x, y, view) result(out)
      logical, intent(in) :: first
      real(wp), intent(in) :: factor
      character(*), intent(in) :: x, y
      type(view_type), intent(in) :: view
      character(:), allocatable :: out
      if (first) then
         out = sum_of(factor*view%cosine, x, -factor*view%sine*view%side, y)
      else
         out = sum_of(factor*view%sine, x, factor*view%cosine*view%side, y)
      end if
   end function mixed

   pure function sum_of(a, x, b, y) result(out)
      real(wp), intent(in) :: a, b
      character(*), intent(in) :: x, y
      character(:), allocatable :: out
      if (abs(b) <= 0.0_wp .or. y == '0') then
         out = times(a, x)
      else if (abs(a) <= 0.0_wp .or. x == '0') then
         out = times(b, y)
      else
         out = number(a)//'*('//x//') + '//number(b)//'*('//y//')'
      end if
   end function sum_of

   !> A law in the numbers of the view, of what it depends on; its value is that of the scene itself.
   function law(text, view) result(out)
      character(*), intent(in) :: text
      type(view_type), intent(inout) :: view
      character(:), allocatable :: out
      integer :: at, last
      out = ''
      at = 1
      do while (at <= len(text))
         if (text(at:at) /= '{') then
            last = scan(text(at:), '{')
            last = merge(len(text), at + last - 2, last == 0)
            out = out//text(at:last)
         else
            last = at + index(text(at:), '}') - 1
            out = out//quantity(text(at + 1:last - 1), view)
         end if
         at = last + 1
      end do
   end function law

   !> A quantity of the scene itself by those of the view.
   function quantity(text, view) result(out)
      character(*), intent(in) :: text
      type(view_type), intent(in) :: view
      character(:), allocatable :: out, name
      real(wp) :: a(2), k
      integer :: colon
      colon = index(text//':', ':')
      name = ''
      if (colon < len(text)) name = name_of(text(colon + 1:), view)
      associate (c => view%cosine, s => view%sine, m => view%units)
         select case (text(:colon - 1))
         case ('t')
            out = 't'
            if (abs(view%start) > 0.0_wp) out = '(t - '//number(view%start)//')'
            if (abs(m(3) - 1.0_wp) > 0.0_wp) out = '('//out//'*'//number(1/m(3))//')'
         case ('x', 'y', 'vx', 'vy')
            a = [c, s]
            if (text(colon - 1:colon - 1) == 'y') a = view%side*[-s, c]
            k = -dot_product(a, view%moved)
            if (text(1:1) == 'v') k = 0.0_wp
            a = a/m(2)
            if (text(1:1) == 'v') a = a*m(3)
            out = sum_of(a(1), quantity_name('x')//'('//name//')', a(2), quantity_name('y')//'('//name//')')
            if (.not. is_plain(view)) out = '('//plus(out, k)//')'
         case ('ang')
            out = 'angle('//name//')'
            if (.not. is_plain(view)) out = number(view%side)//'*('//plus(out, -view%turn)//')'
         case ('spin'); out = times(view%side*m(3), 'spin('//name//')')
         case ('tab'); out = name
         case ('el'); out = times(1/m(2), 'x')
         case ('rate'); out = times(m(3)/m(2), 'v')
         case ('elr'); out = times(view%side, 'x')
         case ('rater'); out = times(view%side*m(3), 'v')
         case ('s'); out = times(1/m(2), 's')
         case ('cx'); out = times(1/m(2), 'x')
         case default; error stop 'a quantity that nobody knows'
         end select
      end associate
      if (scan(out, '*+') > 0) out = '('//out//')'

   contains

      pure function quantity_name(axis) result(full)
         character(*), intent(in) :: axis
         character(:), allocatable :: full
         full = axis
         if (text(1:1) == 'v') full = 'v'//axis
      end function quantity_name

   end function quantity

   !> Whether a block speaks of an object.
   pure logical function mentions(text, name)
      character(*), intent(in) :: text, name
      integer :: at, after
      mentions = .false.
      at = 1
      do
         after = index(text(at:), name)
         if (after == 0) return
         at = at + after - 1
         after = at + len(name)
         if (scan(text(at - 1:at - 1), '|:') == 1 .and. scan(text(after:after), '.|>}_') == 1) mentions = .true.
         if (mentions) return
         at = after
      end do
   end function mentions

   !> What the deck asks for of a channel.
   function asked(channel, view) result(out)
      type(channel_type), intent(in) :: channel
      type(view_type), intent(inout) :: view
      character(:), allocatable :: out
      out = ' '//rendered(channel%first, view)//newline
      if (allocated(channel%second)) out = out//' '//rendered(channel%second, view)//newline
   end function asked

   !> Values of a channel of the scene itself from those that were seen in a view.
   pure subroutine seen_again(channel, view, values)
      type(channel_type), intent(in) :: channel
      type(view_type), intent(in) :: view
      !> One or two rows (rows, samples)
      real(wp), intent(inout) :: values(:, :)
      real(wp) :: factor, p(2)
      integer :: i
      factor = product(view%units**channel%dimension)
      if (channel%swaps .and. view%exchanged) factor = -factor
      select case (channel%kind)
      case (of_place, of_vector)
         do i = 1, size(values, 2)
            p = values(:, i)/factor
            if (channel%kind == of_place) p = p - view%moved
            values(:, i) = [view%cosine*p(1) + view%sine*p(2), view%side*(view%cosine*p(2) - view%sine*p(1))]
         end do
      case default
         if (channel%sign < 0.0_wp) factor = factor*view%side
         values = (values - channel%turned*view%turn*merge(-1.0_wp, 1.0_wp, channel%swaps .and. view%exchanged))/factor
         if (channel%kind == of_change .and. size(values, 2) > 0) values = values - spread(values(:, 1), 2, size(values, 2))
      end select
   end subroutine seen_again

end module views
