!> Named points, and the search for objects by name. Floor: model.
module limber_model_points
   use limber_base_kinds, only: wp
   use limber_base_text, only: nearest_name, lowercase
   use limber_deck_diagnostics, only: diagnostics_type, max_shown
   use limber_deck_origin, only: origin_type
   use limber_model_lists, only: append
   use limber_model_model, only: model_type, point_type
   implicit none
   private
   public :: add_point, find_point, find_body, find_named, enter_name, lies_outside

contains

   !> Whether a coordinate along a beam or member is not on it. Round-off of a coordinate that is computed does not matter.
   elemental logical function lies_outside(x, length)
      !> [length]
      real(wp), intent(in) :: x, length
      real(wp), parameter :: round_off = 1.0e-12_wp
      lies_outside = x < -round_off*length .or. x > (1 + round_off)*length
   end function lies_outside

   !> Appends a point. Its index is the new number of points, `model%counts%points`.
   subroutine add_point(model, name, body, p0, phi, psi, reach)
      type(model_type), intent(inout) :: model
      !> Name of the body and of the point: 'rod.middle'
      character(*), intent(in) :: name
      !> Index of the body, or `ground`
      integer, intent(in) :: body
      !> Undeformed position in the body frame (2) [length]
      real(wp), intent(in) :: p0(2)
      !> Displacement (2,n) and rotation (n) for each coordinate of a flexible body
      real(wp), intent(in), optional :: phi(:, :), psi(:)
      !> Point of an exact beam: weights of the stations in the position of the point (stations)
      real(wp), intent(in), optional :: reach(:)
      type(point_type) :: point
      point%name = name
      point%body = body
      point%p0 = p0
      if (present(phi)) then
         allocate (point%phi, source=phi)
         allocate (point%psi, source=psi)
      else
         allocate (point%phi(2, 0), point%psi(0))
      end if
      if (present(reach)) then
         point%exact = .true.
         allocate (point%reach, source=reach)
      end if
      call append(model%points, model%counts%points, point)
      call enter_name(model, 'point', name, model%counts%points)
   end subroutine add_point

   !> Enters an object under its name. Of several equal names the first one counts.
   subroutine enter_name(model, kind, name, index)
      type(model_type), intent(inout) :: model
      !> Kind of object: 'point', 'body', 'joint', ...; its name, and its index in the list of this kind
      character(*), intent(in) :: kind, name
      integer, intent(in) :: index
      if (model%names%find(kind//' '//name) == 0) call model%names%add(kind//' '//name, index)
   end subroutine enter_name

   !> Index of an object by kind and name; 0 if there is none.
   pure integer function find_named(model, kind, name) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: kind, name
      found = model%names%find(kind//' '//name)
   end function find_named

   !> Index of a body by name; 0 if there is none.
   pure integer function find_body(model, name) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      found = find_named(model, 'body', name)
   end function find_body

   !> Index of a point by its name in the deck: `object.point`, or `object` for the origin of its frame. Adds an error and returns 0
   !> if there is none.
   integer function find_point(model, name, origin, diagnostics) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      !> Place of the name in the deck
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: whole
      whole = lowercase(name)
      if (index(whole, '.') == 0) whole = whole//'.origin'
      found = find_named(model, 'point', whole)
      if (found == 0) call complain(model, lowercase(name), whole, origin, diagnostics)
   end function find_point

   !> Reports that there is no such point, with the names of existing points.
   subroutine complain(model, name, whole, origin, diagnostics)
      type(model_type), intent(in) :: model
      !> Name as written, and with '.origin' where only an object is written
      character(*), intent(in) :: name, whole
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: valid, hint, object
      character(64), allocatable :: all(:)
      integer :: i, near
      hint = 'no body or ground point of this name is defined'
      ! All points of a missing body are reported once
      object = whole
      if (diagnostics%is_told(whole(:index(whole, '.') - 1)) .or. find_body(model, whole(:index(whole, '.') - 1)) == 0 .and. &
         & index(whole, 'ground.') /= 1) object = whole(:index(whole, '.') - 1)
      ! Beyond the number of errors shown no hint is needed
      if (diagnostics%count >= max_shown) then
         call diagnostics%add(origin, "there is no point '"//name//"'", hint, object=object)
         return
      end if
      allocate (all(model%counts%points))
      valid = ''
      do i = 1, size(all)
         all(i) = model%points(i)%name
         if (index(model%points(i)%name, whole(:index(whole, '.'))) /= 1) cycle
         if (valid /= '') valid = valid//', '
         valid = valid//model%points(i)%name
      end do
      if (valid /= '') then
         hint = 'valid: '//valid
      else
         near = nearest_name(whole, all)
         if (near > 0) hint = "did you mean '"//trim(all(near))//"'?"
      end if
      call diagnostics%add(origin, "there is no point '"//name//"'", hint, object=object)
   end subroutine complain

end module limber_model_points
