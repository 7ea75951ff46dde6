!> The list of named points: adding to it, and finding what a deck refers to. Floor: model.
module limber_model_points
   use limber_base_text, only: nearest_name, lowercase
   use limber_deck_diagnostics, only: diagnostics_type
   use limber_deck_origin, only: origin_type
   use limber_model_scene, only: model_type, point_type
   implicit none
   private
   public :: add_point, find_point

contains

   !> Appends a point; one without shapes gets empty ones.
   subroutine add_point(points, point)
      type(point_type), allocatable, intent(inout) :: points(:)
      type(point_type), intent(in) :: point
      type(point_type), allocatable :: longer(:)
      allocate (longer(size(points) + 1))
      longer(:size(points)) = points
      longer(size(longer)) = point
      if (.not. allocated(point%psi)) then
         allocate (longer(size(longer))%phi(2, 0))
         allocate (longer(size(longer))%psi(0))
      end if
      call move_alloc(longer, points)
   end subroutine add_point

   !> Index of the point that a deck names `object.point`, or `object` for the origin of its frame; 0 with a complaint if
   !> there is none.
   integer function find_point(model, name, origin, diagnostics) result(found)
      type(model_type), intent(in) :: model
      character(*), intent(in) :: name
      !> Where it is named
      type(origin_type), intent(in) :: origin
      type(diagnostics_type), intent(inout) :: diagnostics
      character(:), allocatable :: whole, owner
      character(64), allocatable :: own(:), all(:)
      integer :: i, near
      whole = lowercase(name)
      if (index(whole, '.') == 0) whole = whole//'.origin'
      do found = 1, size(model%points)
         if (model%points(found)%name == whole) return
      end do
      found = 0
      owner = whole(:index(whole, '.'))
      allocate (own(0), all(0))
      do i = 1, size(model%points)
         all = [character(64) :: all, model%points(i)%name]
         if (index(model%points(i)%name, owner) == 1) own = [character(64) :: own, model%points(i)%name]
      end do
      if (size(own) > 0) then
         call diagnostics%add(origin, "there is no point '"//lowercase(name)//"'", 'valid: '//listed(own))
      else
         near = nearest_name(whole, all)
         if (near > 0) then
            call diagnostics%add(origin, "there is no point '"//lowercase(name)//"'", "did you mean '"//trim(all(near))//"'?")
         else
            call diagnostics%add(origin, "there is no point '"//lowercase(name)//"'", &
               & 'no body or ground point of this name is defined')
         end if
      end if
   end function find_point

   !> Names separated by commas.
   pure function listed(names) result(text)
      character(*), intent(in) :: names(:)
      character(:), allocatable :: text
      integer :: i
      text = trim(names(1))
      do i = 2, size(names)
         text = text//', '//trim(names(i))
      end do
   end function listed

end module limber_model_points
